/* Builds one patch from a part of a polyline. */
#include "preprocess/patch/strip_build.h"

#include "formats/chunk/measure/strip.h"
#include "preprocess/patch/merged_radius.h"
#include "preprocess/patch/world_lattice.h"

#include <string.h>

/* Most vertices to step over in search of one at another position. */
#define TANGENT_REACH 64u

typedef struct builder {
    const stp_strip_part *part;
    const stp_line_vertex *in; /* the part's first vertex */
    stp_dvec3 chunk_origin;
    stp_patch *patch;
    stp_patch_samples *samples;
    stp_disc vertices[STP_PATCH_SAMPLES]; /* as stored */
    uint8_t chosen[STP_LEVEL_COUNT][STP_STRIP_CANDIDATES];
} builder;

/* ---- lattices ---- */

static stp_dbox part_box(const stp_line_vertex *v, unsigned count)
{
    stp_dbox box = stp_dbox_empty();
    for (unsigned i = 0; i < count; i++)
        stp_dbox_add(&box, v[i].position);
    return box;
}

static int greater(int a, int b)
{
    return a > b ? a : b;
}

int stp_strip_choose_lattice(stp_strip_part *part, double precision, double side)
{
    const stp_line_vertex *v = part->line + part->first;
    const stp_dbox box = part_box(v, part->count);
    double thin = INFINITY, wide = 0.0, length = 0.0;
    for (unsigned i = 0; i < part->count; i++) {
        double radius = stp_line_radius(&v[i]);
        thin = radius > 0.0 ? stp_min(thin, radius) : thin;
        wide = stp_max(wide, radius);
        if (i > 0)
            length += stp_dvec3_length(stp_dvec3_sub(v[i].position, v[i - 1].position));
    }
    const double reach = 0.5 * stp_dvec3_length(stp_dvec3_sub(box.max, box.min)) + wide;
    /* a line's positions are kept to a quarter of its half-width; a ribbon's, whose edges are seen,
     * to a 32nd */
    const double parts = part->kind == STP_LINE_RIBBON ? 1.0 : 0.25 * STP_SPACING_PARTS;
    const double spacing =
        isfinite(thin) ? parts * thin : length / (part->count > 1 ? part->count - 1 : 1);
    int wanted = stp_lattice_exponent(spacing, 0.0, precision, v->position);
    int exponent = stp_lattice_exponent(spacing, 2.0 * reach, precision, v->position);
    const stp_lattices lattices =
        stp_lattices_choose(exponent, &box, part->count > 1 ? reach : 0.0, side);
    part->exponent = lattices.exponent;
    part->vertex_exponent = lattices.vertex_exponent;
    part->first_exponent = part->last_exponent =
        part->count > 1 ? part->exponent : part->vertex_exponent; /* a lone vertex is its disc */
    return part->exponent - wanted;
}

/* ---- level 0 ---- */

/* The direction from the nearest vertex before to the nearest one after that lie elsewhere. */
static vec3s tangent_at(const stp_strip_part *part, uint64_t i)
{
    const stp_line_vertex *line = part->line;
    uint64_t before = i, behind = i;
    for (unsigned n = 0; n < TANGENT_REACH && before > 0 &&
                         stp_dvec3_equal(line[before].position, line[i].position);
         n++)
        before--;
    for (unsigned n = 0; n < TANGENT_REACH && behind + 1 < part->line_count &&
                         stp_dvec3_equal(line[behind].position, line[i].position);
         n++)
        behind++;
    stp_dvec3 way = stp_dvec3_sub(line[behind].position, line[before].position);
    return stp_dvec3_to_float(stp_dvec3_normalize(way));
}

static vec3s direction_at(const stp_strip_part *part, uint64_t i)
{
    vec3s d = part->line[i].direction;
    float length = glms_vec3_norm(d);
    if (isfinite(length) && length > 0.0f)
        return glms_vec3_scale(d, 1.0f / length);
    return part->kind == STP_LINE_TUBE ? tangent_at(part, i) : (vec3s){{0.0f, 0.0f, 0.0f}};
}

static void store_vertex(builder *b, unsigned i, uint32_t greatest)
{
    const stp_strip_part *part = b->part;
    const stp_line_vertex *v = &b->in[i];
    stp_sample *out = &b->samples->level[0][i];
    const vec3s direction = direction_at(part, part->first + i);
    int lattice = part->exponent;
    if (i == 0)
        lattice = greater(lattice, part->first_exponent);
    if (i + 1 == part->count)
        lattice = greater(lattice, part->last_exponent);
    const uint8_t wide = stp_radius_encode(stp_line_radius(v), lattice); /* in both parts */
    *out = (stp_sample){
        .radius = stp_radius_encode(stp_radius_decode(wide, lattice), b->patch->exponent),
        .flags = (uint8_t)((unsigned)part->kind << STP_SAMPLE_KIND_SHIFT),
        .class_id = v->class_id,
        .intensity = (uint8_t)(greatest ? (v->intensity * 255u + greatest / 2) / greatest : 0u)};
    if (glms_vec3_norm2(direction) > 0.0f)
        out->flags |= STP_SAMPLE_HAS_NORMAL;
    stp_normal_encode(direction, out->normal);
    for (int c = 0; c < 3; c++)
        out->rgb[c] = (uint8_t)((v->rgb[c] + 128u) / 257u);
    stp_world_store(b->patch, b->chunk_origin, stp_on_lattice(v->position, lattice), out);
    b->vertices[i] = stp_disc_from_sample(out, b->patch);
}

/* ---- coarser levels ---- */

/* Chooses, for each sample, one of the finer level's samples that it covers. The first and the last
 * vertex stay. */
static stp_strip_loss choose_level(builder *b, int level)
{
    stp_strip_choice choices[STP_STRIP_CANDIDATES] = {{0}};
    const unsigned count = b->patch->counts[level], finer = b->patch->counts[level - 1];
    for (unsigned j = 0; j < count; j++) {
        unsigned begin = stp_level_children_begin(j, count, finer);
        unsigned end = stp_level_children_begin(j + 1, count, finer);
        begin = j + 1 == count ? finer - 1 : begin;
        end = j == 0 ? 1 : end;
        choices[j].count = (uint8_t)(end - begin);
        for (unsigned i = begin; i < end; i++)
            choices[j].vertex[i - begin] = level == 1 ? (uint8_t)i : b->chosen[level - 1][i];
    }
    stp_strip_loss lost = stp_strip_choose(b->vertices, choices, count, b->chosen[level]);
    for (unsigned j = 0; j < count; j++)
        b->samples->level[level][j] = b->samples->level[0][b->chosen[level][j]];
    return lost;
}

/* Mean colour, intensity and direction of the vertices, weighted by half-width; the class of the
 * first vertex. */
static stp_sample mean_sample(const builder *b)
{
    const stp_sample *samples = b->samples->level[0];
    double rgb[3] = {0.0, 0.0, 0.0}, intensity = 0.0, sum = 0.0;
    stp_dvec3 direction = {0.0, 0.0, 0.0};
    stp_sample out = samples[0];
    for (unsigned i = 0; i < b->part->count; i++) {
        double weight = stp_max(b->vertices[i].radius, 1e-300);
        stp_dvec3 d = stp_dvec3_from_float(stp_normal_decode(samples[i].normal));
        double sign = stp_dvec3_dot(d, direction) < 0.0 ? -weight : weight;
        if (samples[i].flags & STP_SAMPLE_HAS_NORMAL)
            direction = stp_dvec3_add(direction, stp_dvec3_scale(d, sign));
        for (int c = 0; c < 3; c++)
            rgb[c] += weight * samples[i].rgb[c];
        intensity += weight * samples[i].intensity;
        sum += weight;
    }
    for (int c = 0; c < 3; c++)
        out.rgb[c] = (uint8_t)lrint(rgb[c] / sum);
    out.intensity = (uint8_t)lrint(intensity / sum);
    stp_normal_encode(stp_dvec3_to_float(stp_dvec3_normalize(direction)), out.normal);
    bool known = stp_dvec3_length(direction) > 0.0;
    out.flags =
        (uint8_t)((out.flags & STP_SAMPLE_KIND_MASK) | (known ? STP_SAMPLE_HAS_NORMAL : 0u));
    return out;
}

/* Stores the disc around all stored vertices. A single vertex is its own disc. */
static void store_disc(const builder *b, stp_sample *out)
{
    stp_dbox box = stp_dbox_empty();
    if (b->part->count == 1) {
        *out = b->samples->level[0][0];
        return;
    }
    *out = mean_sample(b);
    for (unsigned i = 0; i < b->part->count; i++)
        stp_dbox_add(&box, b->vertices[i].centre);
    stp_dvec3 middle = stp_dvec3_scale(stp_dvec3_add(box.min, box.max), 0.5);
    middle = stp_on_lattice(stp_dvec3_add(middle, b->chunk_origin), b->part->vertex_exponent);
    stp_world_store(b->patch, b->chunk_origin, middle, out);
    double reach = stp_strip_reach(b->vertices, b->part->count, stp_sample_position(out, b->patch));
    /* At least a step, so that the radius has a code in the chunk above, too. */
    reach = stp_max(reach, ldexp(1.0, b->part->vertex_exponent));
    out->radius = stp_radius_encode(reach, b->patch->exponent);
}

static void store_loss(stp_patch *patch, int level, stp_strip_loss lost)
{
    patch->error[level] = stp_error_encode(lost.error, patch->exponent);
    patch->colour_error[level] = (uint8_t)ceil(stp_min(255.0, lost.colour_error));
    for (unsigned q = 0; (level == 1 || level == 2) && q < patch->counts[2]; q++)
        patch->quarter_error[level - 1][q] = patch->error[level];
}

static void store_levels(builder *b)
{
    stp_patch *patch = b->patch;
    const int coarsest =
        greater(b->part->exponent, greater(b->part->first_exponent, b->part->last_exponent));
    stp_strip_loss lost = {.error = ldexp(sqrt(3.0) / 2.0, coarsest)};
    for (int l = 1; l < STP_LEVEL_COUNT; l++)
        patch->counts[l] = (uint8_t)stp_level_count_above(patch->counts[l - 1]);
    store_loss(patch, 0, lost);
    for (int l = 1; l < STP_LEVEL_COUNT; l++) {
        stp_strip_loss more = {0};
        if (patch->counts[l] > 1) {
            more = choose_level(b, l);
        } else {
            store_disc(b, &b->samples->level[l][0]);
            stp_disc disc = stp_disc_from_sample(&b->samples->level[l][0], patch);
            if (patch->counts[0] > 1)
                more = stp_strip_disc_lost(b->vertices, patch->counts[0], &disc);
        }
        lost.error = stp_max(lost.error, more.error);
        lost.colour_error = stp_max(lost.colour_error, more.colour_error);
        store_loss(patch, l, lost);
    }
}

/* The bound is the disc's, with a cone of all directions. Also stores the greatest radius of each
 * level. */
static void store_bound(const builder *b)
{
    stp_patch *patch = b->patch;
    const stp_sample *disc = &b->samples->level[STP_LEVEL_COUNT - 1][0];
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        for (unsigned i = 0; i < patch->counts[l]; i++)
            if (b->samples->level[l][i].radius > patch->radius[l])
                patch->radius[l] = b->samples->level[l][i].radius;
    memcpy(patch->bound_centre, disc->position, sizeof patch->bound_centre);
    memcpy(patch->cone_axis, disc->normal, sizeof patch->cone_axis);
    patch->bound_radius = disc->radius;
    patch->cone_angle = stp_cone_angle_encode(M_PI);
}

static void fill_vertex(const builder *b, stp_item *out)
{
    const stp_patch *patch = b->patch;
    const stp_sample *sample = &b->samples->level[STP_LEVEL_COUNT - 1][0];
    stp_disc disc = stp_disc_from_sample(sample, patch);
    const double side = disc.radius / STP_MERGED_LAMBDA;
    disc.centre = stp_dvec3_add(disc.centre, b->chunk_origin);
    disc.low = -disc.radius;
    disc.high = disc.radius;
    disc.cone = M_PI;
    disc.error = stp_error_decode(patch->error[STP_LEVEL_COUNT - 1], patch->exponent);
    disc.colour_error = patch->colour_error[STP_LEVEL_COUNT - 1];
    *out = (stp_item){.disc = disc,
                      .area = side * side,
                      .exponent = b->part->vertex_exponent,
                      .intensity = sample->intensity,
                      .class_id = sample->class_id,
                      .flags = sample->flags,
                      .normal = {sample->normal[0], sample->normal[1], sample->normal[2]}};
}

bool stp_strip_build(const stp_strip_part *part, uint16_t greatest, stp_dvec3 chunk_origin,
                     stp_patch *patch, stp_patch_samples *samples, stp_item *vertex)
{
    builder b = {.part = part,
                 .in = part->line + part->first,
                 .chunk_origin = chunk_origin,
                 .patch = patch,
                 .samples = samples};
    *patch = (stp_patch){.child = STP_PATCH_NO_CHILD,
                         .flags = (uint8_t)(STP_PATCH_TWO_SIDED | STP_PATCH_STRIP |
                                            (part->continues ? STP_PATCH_CONTINUES : 0) |
                                            (part->continued ? STP_PATCH_CONTINUED : 0))};
    patch->counts[0] = (uint8_t)part->count;
    const stp_dbox box = part_box(b.in, part->count);
    const int coarsest =
        greater(part->first_exponent, greater(part->last_exponent, part->vertex_exponent));
    if (!stp_world_place(patch, &box, part->exponent, coarsest, chunk_origin))
        return false;
    for (unsigned i = 0; i < part->count; i++)
        store_vertex(&b, i, greatest);
    store_levels(&b);
    store_bound(&b);
    fill_vertex(&b, vertex);
    return true;
}
