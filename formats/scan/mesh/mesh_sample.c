/* Spreads points over the faces of a mesh. */
#include "formats/scan/mesh/mesh_sample.h"

#include "base/random.h"

#include <math.h>

static void enter(stp_mesh_sampler *s, size_t triangle)
{
    s->triangle = triangle;
    s->triangle_area = stp_point_mesh_area(s->mesh, triangle);
    const double samples = s->triangle_area / s->total_area * (double)s->sample_count;
    s->texels = stp_materials_texels(&s->mesh->materials, triangle) / samples;
}

stp_status stp_mesh_sampler_init(stp_mesh_sampler *sampler, const stp_point_mesh *mesh,
                                 uint64_t sample_count, uint64_t seed, const char *path,
                                 stp_error *err)
{
    double total = 0.0;
    for (size_t i = 0; i < mesh->triangle_count; i++)
        total += stp_point_mesh_area(mesh, i);
    if (!(total > 0.0) || !isfinite(total))
        return stp_error_set(err, STP_EMPTY,
                             "%s: none of its %zu triangles has a positive area to put samples on: "
                             "read the vertices instead (no --sample)",
                             path, mesh->triangle_count);
    *sampler = (stp_mesh_sampler){
        .mesh = mesh, .sample_count = sample_count, .seed = seed, .total_area = total};
    enter(sampler, 0);
    return STP_OK;
}

static uint16_t mix16(const double weights[3], double a, double b, double c)
{
    return (uint16_t)(weights[0] * a + weights[1] * b + weights[2] * c + 0.5);
}

static stp_point interpolate(const stp_mesh_sampler *s, const double w[3])
{
    const stp_point_mesh *mesh = s->mesh;
    const uint32_t *t = mesh->triangles[s->triangle];
    const stp_point *p[3] = {&mesh->points[t[0]], &mesh->points[t[1]], &mesh->points[t[2]]};
    stp_point out = {0};
    stp_dvec3 normal = {0.0, 0.0, 0.0};
    int nearest = 0;
    /* Computed relative to the first corner, so that large coordinates keep their digits. */
    out.position = p[0]->position;
    for (int k = 0; k < 3; k++) {
        const stp_dvec3 edge = stp_dvec3_sub(p[k]->position, p[0]->position);
        out.position = stp_dvec3_add(out.position, stp_dvec3_scale(edge, w[k]));
        normal = stp_dvec3_add(normal, stp_dvec3_scale(stp_dvec3_from_float(p[k]->normal), w[k]));
        nearest = w[k] > w[nearest] ? k : nearest;
    }
    out.normal = stp_unit_normal(normal);
    for (int c = 0; c < 3; c++)
        out.rgb[c] = mix16(w, p[0]->rgb[c], p[1]->rgb[c], p[2]->rgb[c]);
    (void)stp_materials_colour(&s->mesh->materials, s->triangle, w, s->texels, out.rgb);
    out.intensity = mix16(w, p[0]->intensity, p[1]->intensity, p[2]->intensity);
    out.class_id = p[nearest]->class_id;
    return out;
}

/* Goes to the triangle that holds this share of the total area. */
static void advance(stp_mesh_sampler *s, double wanted)
{
    while (wanted >= s->area_before + s->triangle_area || s->triangle_area <= 0.0) {
        size_t next = s->triangle + 1;
        /* Rounding may put the last share at the very end. Then it stays in the last triangle with
         * an area. */
        while (next < s->mesh->triangle_count && stp_point_mesh_area(s->mesh, next) <= 0.0)
            next++;
        if (next == s->mesh->triangle_count)
            return;
        s->area_before += s->triangle_area;
        enter(s, next);
    }
}

size_t stp_mesh_sampler_next(stp_mesh_sampler *s, stp_point *points, size_t capacity)
{
    size_t count = 0;
    for (; count < capacity && s->next < s->sample_count; count++, s->next++) {
        const uint64_t counter = s->next * 3;
        const double jitter = stp_random_unit(s->seed, counter);
        advance(s, ((double)s->next + jitter) / (double)s->sample_count * s->total_area);
        const double root = sqrt(stp_random_unit(s->seed, counter + 1));
        const double along = stp_random_unit(s->seed, counter + 2);
        const double weights[3] = {1.0 - root, root * (1.0 - along), root * along};
        points[count] = interpolate(s, weights);
    }
    for (; count < capacity && s->next_loose < s->mesh->loose_count; count++)
        points[count] = s->mesh->points[s->mesh->loose[s->next_loose++]];
    return count;
}
