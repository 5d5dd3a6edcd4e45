/* Builds one patch from up to 21 triangles. */
#include "preprocess/patch/triangle_build.h"

#include "formats/chunk/measure/triangles.h"
#include "formats/chunk/sample/normal_grid.h"
#include "preprocess/patch/world_lattice.h"

#include <string.h>

/* Normals of discs are rounded by at most 0.33 degrees: they stand for triangles that lie at many
 * more. */
#define DISC_NORMAL_BITS 9u

typedef struct builder {
    const stp_triangle_source *source;
    const stp_triangle_part *part;
    stp_dvec3 chunk_origin;
    stp_patch *patch;
    stp_patch_samples *samples;
    stp_disc corners[STP_PATCH_SAMPLES];         /* as stored */
    stp_dvec3 normals[STP_PATCH_TRIANGLE_COUNT]; /* of triangles, unit or zero */
    double areas[STP_PATCH_TRIANGLE_COUNT];
} builder;

static const stp_line_vertex *corner_of(const builder *b, unsigned i)
{
    return &b->source->set->vertices[stp_corner_vertex(b->source, b->part, i)];
}

static void store_corner(builder *b, unsigned i, uint32_t greatest)
{
    const stp_line_vertex *v = corner_of(b, i);
    const int lattice = b->source->exponents[stp_corner_vertex(b->source, b->part, i)];
    const double radius = isfinite(v->radius) && v->radius > 0.0f ? (double)v->radius : 0.0;
    const double wide = stp_radius_decode(stp_radius_encode(radius, lattice), lattice);
    stp_sample *out = &b->samples->level[0][i];
    *out = (stp_sample){
        .radius = stp_radius_encode(wide, b->patch->exponent),
        .flags = STP_KIND_POLYGON << STP_SAMPLE_KIND_SHIFT,
        .class_id = v->class_id,
        .intensity = (uint8_t)(greatest ? (v->intensity * 255u + greatest / 2) / greatest : 0u)};
    for (int c = 0; c < 3; c++)
        out->rgb[c] = (uint8_t)((v->rgb[c] + 128u) / 257u);
    stp_world_store(b->patch, b->chunk_origin, stp_on_lattice(v->position, lattice), out);
}

/* Stores the vertex's normal; if it has none, the triangle's. */
static void store_normal(builder *b, unsigned i)
{
    const stp_line_vertex *v = corner_of(b, i);
    stp_sample *out = &b->samples->level[0][i];
    const float length = glms_vec3_norm(v->direction);
    vec3s n = isfinite(length) && length > 0.0f ? glms_vec3_scale(v->direction, 1.0f / length)
                                                : stp_dvec3_to_float(b->normals[i / 3]);
    if (glms_vec3_norm2(n) > 0.0f)
        out->flags |= STP_SAMPLE_HAS_NORMAL;
    stp_normal_encode(n, out->normal);
    b->corners[i] = stp_disc_from_sample(out, b->patch);
}

static void store_corners(builder *b, uint32_t greatest)
{
    for (unsigned i = 0; i < 3 * b->part->count; i++) {
        store_corner(b, i, greatest);
        b->corners[i] = stp_disc_from_sample(&b->samples->level[0][i], b->patch);
    }
    for (unsigned t = 0; t < b->part->count; t++) {
        const stp_disc *c = &b->corners[3 * t];
        stp_dvec3 cross = stp_dvec3_cross(stp_dvec3_sub(c[1].centre, c[0].centre),
                                          stp_dvec3_sub(c[2].centre, c[0].centre));
        b->areas[t] = 0.5 * stp_dvec3_length(cross);
        b->normals[t] = stp_dvec3_normalize(cross);
    }
    for (unsigned i = 0; i < 3 * b->part->count; i++)
        store_normal(b, i);
}

/* ---- discs ---- */

/* Mean of the samples of the finer level that a disc covers, as a sample without radius: what the
 * codec expects. *middle: its position. */
static stp_sample mean_sample(const builder *b, int level, unsigned j, stp_dvec3 *middle)
{
    const unsigned finer = b->patch->counts[level - 1], count = b->patch->counts[level];
    const unsigned end = stp_level_children_begin(j + 1, count, finer);
    unsigned i = stp_level_children_begin(j, count, finer);
    double rgb[3] = {0.0, 0.0, 0.0}, intensity = 0.0, sum = 0.0;
    stp_dvec3 centre = {0.0, 0.0, 0.0}, normal = centre;
    stp_sample out = {.class_id = b->samples->level[level - 1][i].class_id};
    for (; i < end; i++) {
        const stp_sample *s = &b->samples->level[level - 1][i];
        const stp_disc disc = stp_disc_from_sample(s, b->patch);
        const double weight = level > 1 ? disc.radius * disc.radius : 1.0;
        centre = stp_dvec3_add(centre, stp_dvec3_scale(disc.centre, weight));
        normal = stp_dvec3_add(normal, stp_dvec3_scale(disc.normal, weight));
        for (int c = 0; c < 3; c++)
            rgb[c] += weight * s->rgb[c];
        intensity += weight * s->intensity;
        sum += weight;
    }
    *middle = stp_dvec3_scale(centre, 1.0 / sum);
    for (int c = 0; c < 3; c++)
        out.rgb[c] = (uint8_t)lrint(rgb[c] / sum);
    out.intensity = (uint8_t)lrint(intensity / sum);
    normal = stp_dvec3_normalize(normal);
    stp_normal_encode_on(stp_dvec3_to_float(normal), DISC_NORMAL_BITS, out.normal);
    out.flags = stp_dvec3_length(normal) > 0.5 ? STP_SAMPLE_HAS_NORMAL : 0;
    return out;
}

/* How far the corners lie from a disc's centre, measured in the disc's plane. */
static double reach_of(const builder *b, const stp_disc *disc, unsigned first, unsigned end)
{
    double reach = 0.0;
    for (unsigned i = 3 * first; i < 3 * end; i++) {
        stp_dvec3 d = stp_dvec3_sub(b->corners[i].centre, disc->centre);
        double height = stp_dvec3_dot(d, disc->normal);
        reach = stp_max(reach, sqrt(stp_max(0.0, stp_dvec3_dot(d, d) - height * height)));
    }
    return reach;
}

static stp_triangles_loss worse(stp_triangles_loss a, stp_triangles_loss b)
{
    return (stp_triangles_loss){stp_max(a.error, b.error),
                                stp_max(a.tangential_error, b.tangential_error),
                                stp_max(a.colour_error, b.colour_error)};
}

static stp_triangles_loss store_disc(builder *b, int level, unsigned j)
{
    unsigned first, end;
    stp_dvec3 middle;
    stp_sample *out = &b->samples->level[level][j];
    stp_triangles_under(b->patch->counts, level, j, &first, &end);
    *out = mean_sample(b, level, j, &middle);
    const int lattice = level == STP_LEVEL_COUNT - 1 ? b->part->vertex_exponent : b->part->exponent;
    stp_world_store(b->patch, b->chunk_origin,
                    stp_on_lattice(stp_dvec3_add(middle, b->chunk_origin), lattice), out);
    stp_disc disc = stp_disc_from_sample(out, b->patch);
    const double least = ldexp(1.0, lattice); /* so that it has a code in the chunk above */
    const double reach = stp_max(reach_of(b, &disc, first, end), least);
    out->radius = stp_radius_encode(reach, b->patch->exponent);
    disc = stp_disc_from_sample(out, b->patch);
    return stp_triangles_lost(&disc, b->corners, first, end);
}

static void store_loss(stp_patch *patch, int level, stp_triangles_loss lost)
{
    patch->error[level] = stp_error_encode(lost.error, patch->exponent);
    patch->tangential_error[level] = stp_error_encode(lost.tangential_error, patch->exponent);
    patch->colour_error[level] = (uint8_t)ceil(stp_min(255.0, lost.colour_error));
    for (unsigned q = 0; (level == 1 || level == 2) && q < patch->counts[2]; q++) {
        patch->quarter_error[level - 1][q] = patch->error[level];
        patch->quarter_tangential_error[level - 1][q] = patch->tangential_error[level];
    }
}

static void store_levels(builder *b)
{
    stp_patch *patch = b->patch;
    stp_triangles_loss lost = {.error = ldexp(sqrt(3.0) / 2.0, b->part->coarsest)};
    for (int l = 1; l < STP_LEVEL_COUNT; l++)
        patch->counts[l] = (uint8_t)stp_level_count_above(patch->counts[l - 1]);
    store_loss(patch, 0, lost);
    for (int l = 1; l < STP_LEVEL_COUNT; l++) {
        for (unsigned j = 0; j < patch->counts[l]; j++)
            lost = worse(lost, store_disc(b, l, j));
        store_loss(patch, l, lost);
    }
}

/* ---- bounds ---- */

static double angle_between(stp_dvec3 a, stp_dvec3 b)
{
    bool known = stp_dvec3_length(a) > 0.0 && stp_dvec3_length(b) > 0.0;
    return known ? acos(stp_max(-1.0, stp_min(1.0, stp_dvec3_dot(a, b)))) : M_PI;
}

/* Sets the cone of the normals of triangles, corners and discs, and the ball around them. */
static void store_bound(const builder *b)
{
    stp_patch *patch = b->patch;
    double angle = 0.0, radius = 0.0;
    const stp_sample *vertex = &b->samples->level[STP_LEVEL_COUNT - 1][0];
    memcpy(patch->cone_axis, vertex->normal, sizeof patch->cone_axis);
    const stp_dvec3 axis = stp_dvec3_from_float(stp_normal_decode(patch->cone_axis));
    for (unsigned t = 0; t < b->part->count; t++)
        angle = stp_max(angle, angle_between(axis, b->normals[t]));
    memcpy(patch->bound_centre, vertex->position, sizeof patch->bound_centre);
    const stp_dvec3 c = stp_sample_position(vertex, patch);
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        for (unsigned i = 0; i < patch->counts[l]; i++) {
            const stp_sample *s = &b->samples->level[l][i];
            const stp_disc d = stp_disc_from_sample(s, patch);
            radius = stp_max(radius, stp_dvec3_length(stp_dvec3_sub(d.centre, c)) + d.radius);
            angle = stp_max(angle, angle_between(axis, d.normal));
            patch->radius[l] = s->radius > patch->radius[l] ? s->radius : patch->radius[l];
        }
    patch->cone_angle = stp_cone_angle_encode(stp_min(M_PI, angle + 1e-6));
    patch->bound_radius = stp_radius_encode(radius, patch->exponent);
}

static void fill_vertex(const builder *b, stp_item *out)
{
    const stp_patch *patch = b->patch;
    const stp_sample *sample = &b->samples->level[STP_LEVEL_COUNT - 1][0];
    stp_disc disc = stp_disc_from_sample(sample, patch);
    double area = 0.0;
    disc.reach = stp_max(disc.radius, reach_of(b, &disc, 0, b->part->count));
    for (unsigned i = 0; i < patch->counts[0]; i++) {
        stp_dvec3 d = stp_dvec3_sub(b->corners[i].centre, disc.centre);
        disc.low = stp_min(disc.low, stp_dvec3_dot(d, disc.normal));
        disc.high = stp_max(disc.high, stp_dvec3_dot(d, disc.normal));
        disc.bound = stp_max(disc.bound, stp_dvec3_length(d) + b->corners[i].radius);
    }
    for (unsigned t = 0; t < b->part->count; t++) {
        area += b->areas[t];
        disc.cone = stp_max(disc.cone, angle_between(disc.normal, b->normals[t]));
    }
    disc.centre = stp_dvec3_add(disc.centre, b->chunk_origin);
    disc.error = stp_error_decode(patch->error[STP_LEVEL_COUNT - 1], patch->exponent);
    disc.tangential_error =
        stp_error_decode(patch->tangential_error[STP_LEVEL_COUNT - 1], patch->exponent);
    disc.colour_error = patch->colour_error[STP_LEVEL_COUNT - 1];
    *out = (stp_item){.disc = disc,
                      .area = area,
                      .exponent = b->part->vertex_exponent,
                      .intensity = sample->intensity,
                      .class_id = sample->class_id,
                      .flags = sample->flags,
                      .normal = {sample->normal[0], sample->normal[1], sample->normal[2]}};
}

bool stp_triangles_build(const stp_triangle_source *source, const stp_triangle_part *part,
                         uint16_t greatest, stp_dvec3 chunk_origin, stp_patch *patch,
                         stp_patch_samples *samples, stp_item *vertex)
{
    builder b = {.source = source,
                 .part = part,
                 .chunk_origin = chunk_origin,
                 .patch = patch,
                 .samples = samples};
    *patch = (stp_patch){.child = STP_PATCH_NO_CHILD,
                         .flags = STP_PATCH_TWO_SIDED | STP_PATCH_TRIANGLES};
    patch->counts[0] = (uint8_t)(3 * part->count);
    stp_dbox box = stp_dbox_empty();
    for (unsigned i = 0; i < 3 * part->count; i++)
        stp_dbox_add(&box, corner_of(&b, i)->position);
    const int coarsest =
        part->coarsest > part->vertex_exponent ? part->coarsest : part->vertex_exponent;
    if (!stp_world_place(patch, &box, part->exponent, coarsest, chunk_origin))
        return false;
    store_corners(&b, greatest);
    store_levels(&b);
    store_bound(&b);
    fill_vertex(&b, vertex);
    return true;
}
