/* What lines look like: they are made triangles again, and their silhouettes are compared with the
 * mesh's that they came from.
 *
 * A ribbon is flat across its normal and cut square at its ends. A tube is a prism of twelve sides
 * whose mean width is twice the radius. */
#ifndef STP_TESTS_PLANT_SILHOUETTE_H
#define STP_TESTS_PLANT_SILHOUETTE_H

#include "tests/plant_fixture.h"
#include "tests/support/triangles.h"
#include "tests/support/views.h"

enum { SILHOUETTE_SIDES = 12 };

/* Pixels, summed over the 26 directions. */
typedef struct silhouette_sum {
    double mesh, lines, both;         /* covered; both: by the mesh and by the lines */
    double mesh_layers, lines_layers; /* triangles that cover them: nothing hides anything */
} silhouette_sum;

/* At a line's vertex: where the line goes and what is at right angles to that. */
typedef struct silhouette_frame {
    stp_dvec3 at, along, side, up;
    double radius;
} silhouette_frame;

static inline stp_dvec3 silhouette_mix(stp_dvec3 a, stp_dvec3 b, double s, stp_dvec3 c, double t)
{
    return stp_dvec3_add(a, stp_dvec3_add(stp_dvec3_scale(b, s), stp_dvec3_scale(c, t)));
}

static inline silhouette_frame silhouette_frame_at(const stp_plant *plant,
                                                   const stp_line_strip *strip, uint64_t i)
{
    const stp_line_vertex *v = plant->lines.vertices + strip->begin;
    const uint64_t before = i > 0 ? i - 1 : 0, after = i + 1 < strip->count ? i + 1 : i;
    const stp_dvec3 direction = stp_dvec3_from_float(v[i].direction);
    silhouette_frame f = {.at = v[i].position, .radius = (double)v[i].radius};
    f.along = stp_dvec3_normalize(stp_dvec3_sub(v[after].position, v[before].position));
    if (strip->kind == STP_LINE_RIBBON) {
        f.side = stp_dvec3_normalize(stp_dvec3_cross(direction, f.along));
        return f;
    }
    const double pi = 3.14159265358979323846;
    const stp_dvec3 axis =
        fabs(f.along.x) < 0.7 ? (stp_dvec3){1.0, 0.0, 0.0} : (stp_dvec3){0.0, 1.0, 0.0};
    f.side = stp_dvec3_normalize(stp_dvec3_cross(f.along, axis));
    f.up = stp_dvec3_cross(f.along, f.side);
    f.radius *= pi / (SILHOUETTE_SIDES * sin(pi / SILHOUETTE_SIDES));
    return f;
}

static inline void silhouette_add_ribbon(plant_mesh *out, const stp_plant *plant,
                                         const stp_line_strip *strip)
{
    for (uint64_t i = 0; i + 1 < strip->count; i++) {
        const silhouette_frame f = silhouette_frame_at(plant, strip, i);
        uint32_t last = 0;
        const silhouette_frame g = silhouette_frame_at(plant, strip, i + 1);
        for (int k = 0; k < 4; k++) {
            const silhouette_frame *at = k < 2 ? &f : &g;
            const double reach = k == 0 || k == 3 ? at->radius : -at->radius;
            const stp_dvec3 p = silhouette_mix(at->at, at->side, reach, at->along, 0.0);
            last = plant_mesh_vertex(out, p.x, p.y, p.z);
        }
        plant_mesh_quad(out, last - 3, last - 2, last - 1, last);
    }
}

static inline void silhouette_add_tube(plant_mesh *out, const stp_plant *plant,
                                       const stp_line_strip *strip)
{
    for (uint64_t i = 0; i + 1 < strip->count; i++) {
        silhouette_frame ends[2] = {silhouette_frame_at(plant, strip, i),
                                    silhouette_frame_at(plant, strip, i + 1)};
        const uint32_t first = (uint32_t)out->mesh.vertex_count;
        for (int e = 0; e < 2; e++)
            for (int k = 0; k < SILHOUETTE_SIDES; k++) {
                const double angle = 6.28318530717958647692 * k / SILHOUETTE_SIDES;
                const stp_dvec3 p =
                    silhouette_mix(ends[e].at, ends[0].side, ends[e].radius * cos(angle),
                                   ends[0].up, ends[e].radius * sin(angle));
                plant_mesh_vertex(out, p.x, p.y, p.z);
            }
        plant_mesh_join(out, first, first + SILHOUETTE_SIDES, SILHOUETTE_SIDES);
    }
}

/* All lines, and the triangles that were kept. Free with plant_mesh_clear. */
static inline plant_mesh silhouette_triangles(const stp_plant *plant)
{
    const size_t rest = plant->rest->triangle_count;
    const size_t lines = (size_t)plant->lines.vertex_count;
    const size_t each = 2 * SILHOUETTE_SIDES; /* of a line's vertex */
    plant_mesh out =
        plant_mesh_create(lines * each + plant->rest->vertex_count, lines * each + rest);
    for (uint64_t i = 0; i < plant->rest->vertex_count; i++) {
        const stp_dvec3 p = plant->rest->positions[i];
        plant_mesh_vertex(&out, p.x, p.y, p.z);
    }
    for (uint64_t i = 0; i < rest; i++) {
        const uint32_t *t = plant->rest->triangles[i];
        plant_mesh_triangle(&out, t[0], t[1], t[2]);
    }
    for (uint64_t i = 0; i < plant->lines.strip_count; i++) {
        const stp_line_strip *strip = &plant->lines.strips[i];
        if (strip->kind == STP_LINE_RIBBON)
            silhouette_add_ribbon(&out, plant, strip);
        else
            silhouette_add_tube(&out, plant, strip);
    }
    return out;
}

static inline triangles_picture silhouette_draw(const stp_mesh *mesh, const stp_view *view)
{
    const triangles_mesh drawn = {.vertex_count = (size_t)mesh->vertex_count,
                                  .triangle_count = (size_t)mesh->triangle_count,
                                  .positions = mesh->positions,
                                  .triangles = (const uint32_t(*)[3])mesh->triangles};
    triangles_picture picture;
    check_ok(triangles_draw(&picture, &drawn, view, err));
    return picture;
}

/* The mesh and what became of it, in pictures of size x size pixels. */
static inline silhouette_sum silhouette_compare(const stp_mesh *mesh, const stp_plant *plant,
                                                int size)
{
    silhouette_sum sum = {0};
    plant_mesh lines = silhouette_triangles(plant);
    stp_dbox box = stp_dbox_empty();
    for (uint64_t i = 0; i < mesh->vertex_count; i++)
        stp_dbox_add(&box, mesh->positions[i]);
    const stp_ball ball = stp_ball_from_box(&box);
    for (int i = 0; i < VIEWS_DIRECTIONS; i++) {
        const stp_view view = views_get(i, &ball, NULL, 0, size, size);
        triangles_picture a = silhouette_draw(mesh, &view);
        triangles_picture b = silhouette_draw(&lines.mesh, &view);
        for (int k = 0; k < size * size; k++) {
            const uint32_t p = a.pixels[k].layers, q = b.pixels[k].layers;
            sum.mesh += p > 0;
            sum.lines += q > 0;
            sum.both += p > 0 && q > 0;
            sum.mesh_layers += p;
            sum.lines_layers += q;
        }
        triangles_destroy(&a);
        triangles_destroy(&b);
    }
    plant_mesh_clear(&lines);
    return sum;
}

/* Says the figures; the silhouettes' areas differ by no more than `area`, all the parts' by no more
 * than `layers`, and at least the share `both` of what either covers is covered by both. */
static inline void silhouette_check(const silhouette_sum *sum, double area, double layers,
                                    double both)
{
    const double overlap = sum->both / (sum->mesh + sum->lines - sum->both);
    print_message("silhouette %.4f of the mesh's, parts %.4f, overlap %.4f\n",
                  sum->lines / sum->mesh, sum->lines_layers / sum->mesh_layers, overlap);
    check_near(sum->lines / sum->mesh, 1.0, area);
    check_near(sum->lines_layers / sum->mesh_layers, 1.0, layers);
    assert_true(overlap >= both);
}

#endif
