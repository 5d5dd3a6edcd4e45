/* Codes samples as columns of small numbers: predicts them from the parent, the siblings and the
 * plane. */
#include "formats/chunk/codec/predict/predict.h"

#include "formats/chunk/codec/predict/predict_normal.h"
#include "formats/chunk/sample/normal_grid.h"
#include "formats/chunk/sample/sublattice.h"

#include <stdlib.h>

#define INLINE STP_INLINE

/* Components of a sample as plain numbers. Those whose parent is the mean of its children come
 * first. */
enum { PX, PY, PZ, RED, GREEN, BLUE, INTENSITY, NU, NV, CLASS, FLAGS, RADIUS, COMPONENT_COUNT };
#define MEAN_COUNT NU

static const int32_t component_mask[COMPONENT_COUNT] = {0xffff, 0xffff, 0xffff, 0xff, 0xff, 0xff,
                                                        0xff,   0xfff,  0xfff,  0xff, 0xff, 0xff};

typedef struct parts {
    int32_t v[COMPONENT_COUNT];
} parts;

INLINE parts sample_unpack(const stp_sample *s)
{
    parts p = {{s->position[0], s->position[1], s->position[2], s->rgb[0], s->rgb[1], s->rgb[2],
                s->intensity, 0, 0, s->class_id, s->flags, s->radius}};
    stp_normal_codes_get(s->normal, &p.v[NU]);
    return p;
}

INLINE void sample_pack(const parts *p, stp_sample *out)
{
    for (int i = 0; i < 3; i++) {
        out->position[i] = (uint16_t)p->v[PX + i];
        out->rgb[i] = (uint8_t)p->v[RED + i];
    }
    stp_normal_codes_put(&p->v[NU], out->normal);
    out->intensity = (uint8_t)p->v[INTENSITY];
    out->class_id = (uint8_t)p->v[CLASS];
    out->flags = (uint8_t)p->v[FLAGS];
    out->radius = (uint8_t)p->v[RADIUS];
}

/* The cells of one row of a table. Decoding turns residuals into values, encoding values into
 * residuals; both share the code of the predictions. `decode` is a constant in each caller and
 * everything is inlined, so the compiler makes two straight loops of it. */
typedef struct coder {
    int16_t *cells; /* column c is cells[c * stride] */
    size_t stride;
    stp_normal_grid grid;   /* that all normals are on */
    unsigned radius_shift;  /* likewise of radii */
    unsigned sublattice;    /* of the patch's positions */
    const int32_t *origin;  /* of the patch */
    const stp_chunk *block; /* to recall corners in; and the patch at hand */
    const stp_patch *patch;
    stp_scale scale; /* of positions */
    stp_patch_scale patch_scale;
    bool decode;
} coder;

INLINE coder table_coder(const stp_table *table, bool decode)
{
    return (coder){.cells = table->values,
                   .stride = table->stride,
                   .grid =
                       stp_normal_grid_of(stp_normal_step(table->normal_shift, table->normal_odd)),
                   .radius_shift = table->radius_shift,
                   .scale = table->scale,
                   .decode = decode};
}

/* The residual of least magnitude, modulo the component's range. */
INLINE int16_t wrap(int32_t difference, int32_t mask)
{
    int32_t low = difference & mask;
    return (int16_t)(low > mask >> 1 ? low - mask - 1 : low);
}

INLINE void code(const coder *c, int column, int component, int32_t predicted, parts *p)
{
    int16_t *residual = c->cells + (size_t)column * c->stride;
    int32_t mask = component_mask[component];
    if (c->decode)
        p->v[component] = (predicted + *residual) & mask;
    else
        *residual = wrap(p->v[component] - predicted, mask);
}

/* Codes colours. Predicts red and blue with the residual of green, unless `free`. */
INLINE void code_colours(const coder *c, const parts *predicted, bool free, parts *p)
{
    code(c, STP_COLUMN_GREEN, GREEN, predicted->v[GREEN], p);
    int32_t moved = free ? 0 : wrap(p->v[GREEN] - predicted->v[GREEN], 0xff);
    code(c, STP_COLUMN_RED, RED, predicted->v[RED] + moved, p);
    code(c, STP_COLUMN_BLUE, BLUE, predicted->v[BLUE] + moved, p);
    code(c, STP_COLUMN_INTENSITY, INTENSITY, predicted->v[INTENSITY], p);
}

/* Codes a coordinate of a normal by places on the grid. */
INLINE void code_place(const coder *c, int column, int component, int32_t predicted, parts *p)
{
    int16_t *residual = c->cells + (size_t)column * c->stride;
    int32_t place = stp_normal_place_near(&c->grid, predicted);
    if (c->decode)
        p->v[component] = stp_normal_code_at(&c->grid, place + *residual);
    else
        *residual = (int16_t)(stp_normal_place_of(&c->grid, p->v[component]) - place);
}

INLINE void code_normal(const coder *c, const parts *predicted, parts *p)
{
    if (c->grid.step > 1) {
        code_place(c, STP_COLUMN_NORMAL_U, NU, predicted->v[NU], p);
        code_place(c, STP_COLUMN_NORMAL_V, NV, predicted->v[NV], p);
        return;
    }
    code(c, STP_COLUMN_NORMAL_U, NU, predicted->v[NU], p);
    code(c, STP_COLUMN_NORMAL_V, NV, predicted->v[NV], p);
}

/* Divides many times by one divisor (1..2^13), by its reciprocal. Exact for 32-bit values (Lemire,
 * Kaser, Kurz 2019, "Faster remainder by direct computation"). */
typedef struct divisor {
    uint64_t reciprocal; /* floor(2^64 / divisor) + 1; 0 stands for 2^64, the divisor 1 */
    uint32_t half;
} divisor;

INLINE divisor divisor_of(int32_t value)
{
    return (divisor){UINT64_MAX / (uint32_t)value + 1, (uint32_t)value / 2};
}

/* Quotient rounded to nearest, halves away from zero. |value| < 2^31. */
INLINE int32_t divide(int32_t value, divisor d)
{
    uint32_t raised = (uint32_t)abs(value) + d.half;
    uint64_t quotient = (uint64_t)((unsigned __int128)d.reciprocal * raised >> 64);
    int32_t magnitude = (int32_t)(d.reciprocal == 0 ? raised : quotient);
    return value < 0 ? -magnitude : magnitude;
}

/* The plane of a family: one axis follows from the other two. */
typedef struct plane {
    stp_ivec3 normal;
    int a, b, main_axis; /* main_axis: the normal's greatest */
    divisor along;
} plane;

INLINE plane plane_of(stp_ivec3 normal)
{
    int axis = stp_main_axis(normal);
    plane out = {.normal = normal, .a = (axis + 1) % 3, .b = (axis + 2) % 3, .main_axis = axis};
    out.along = divisor_of(abs(normal.v[out.main_axis]));
    return out;
}

/* Codes a coordinate by places on the patch's sublattice, which is not 0. before: see
 * stp_sublattice_axis_of. */
INLINE void code_step(const coder *c, int column, int axis, uint32_t before, int32_t predicted,
                      parts *p)
{
    int16_t *residual = c->cells + (size_t)column * c->stride;
    int32_t *value = &p->v[PX + axis];
    const stp_sublattice_axis on = stp_sublattice_axis_of(
        c->sublattice, column - STP_COLUMN_POSITION_A, before, c->origin[axis]);
    const int32_t place = (predicted - on.offset + (1 << on.shift >> 1)) >> on.shift;
    if (c->decode)
        *value = ((place + *residual) * (1 << on.shift) + on.offset) & 0xffff;
    else
        *residual = wrap(((*value - on.offset) >> on.shift) - place, 0xffff >> on.shift);
}

/* Codes the last coordinate by places on the patch's slanted sublattice. */
INLINE void code_slanted(const coder *c, int axis, int32_t predicted, parts *p)
{
    int16_t *residual = c->cells + (size_t)STP_COLUMN_POSITION_C * c->stride;
    const int32_t own = p->v[PX + axis], count = stp_slanted_parts(c->sublattice);
    p->v[PX + axis] = 0;
    const int32_t offset =
        stp_slanted_offset(c->sublattice, axis, stp_slanted_sum(c->origin, &p->v[PX]));
    const int32_t raised = predicted - offset + count / 2;
    const int32_t place = raised / count - (raised % count < 0);
    p->v[PX + axis] = own;
    if (c->decode)
        p->v[PX + axis] = ((place + *residual) * count + offset) & 0xffff;
    else
        *residual = wrap((own - offset) / count - place, 0xffff);
}

/* Codes a coordinate of a position: if the patch has a scale, by places on the scale. */
INLINE void code_coordinate(const coder *c, int column, int axis, uint32_t before,
                            int32_t predicted, parts *p)
{
    int16_t *residual = c->cells + (size_t)column * c->stride;
    int32_t *value = &p->v[PX + axis];
    const bool slanted = c->sublattice >= STP_SLANTED;
    if (!c->patch_scale.used && slanted && column == STP_COLUMN_POSITION_C) {
        code_slanted(c, axis, predicted, p);
        return;
    }
    if (!c->patch_scale.used && c->sublattice > 0 && !slanted) {
        code_step(c, column, axis, before, predicted, p);
        return;
    }
    if (!c->patch_scale.used) {
        code(c, column, PX + axis, predicted, p);
        return;
    }
    int32_t place = stp_scale_place(&c->patch_scale, axis, predicted & 0xffff);
    if (c->decode)
        *value = stp_scale_position(&c->patch_scale, axis, (place + *residual) & 0xffff);
    else
        *residual = wrap(stp_scale_place(&c->patch_scale, axis, *value) - place, 0xffff);
}

/* Codes two axes as they are, and the third predicted by normal . (p - predicted) = 0, unless
 * `free`. */
INLINE void code_position(const coder *c, const parts *predicted, const plane *on, bool free,
                          parts *p)
{
    int main_axis = on->main_axis;
    int a = on->a;
    int b = on->b;
    int32_t rise = 0;
    code_coordinate(c, STP_COLUMN_POSITION_A, a, 0, predicted->v[PX + a], p);
    const uint32_t first = (uint32_t)p->v[PX + a] + (uint32_t)c->origin[a];
    code_coordinate(c, STP_COLUMN_POSITION_B, b, first, predicted->v[PX + b], p);
    if (!free) {
        int32_t slope = on->normal.v[a] * (p->v[PX + a] - predicted->v[PX + a]) +
                        on->normal.v[b] * (p->v[PX + b] - predicted->v[PX + b]);
        rise = divide(on->normal.v[main_axis] < 0 ? slope : -slope, on->along);
    }
    const bool face = c->sublattice % STP_SUBLATTICE_KINDS == 1;
    const uint32_t both = first + (face ? (uint32_t)p->v[PX + b] + (uint32_t)c->origin[b] : 0);
    code_coordinate(c, STP_COLUMN_POSITION_C, main_axis, both, predicted->v[PX + main_axis] + rise,
                    p);
}

/* ---- level 3 ---- */

INLINE parts vertex_prediction(const stp_patch *patch, const parts *previous)
{
    parts p = *previous;
    for (int i = 0; i < 3; i++)
        p.v[PX + i] = patch->bound_centre[i];
    stp_normal_codes_get(patch->cone_axis, &p.v[NU]);
    p.v[RADIUS] = patch->radius[STP_LEVEL_COUNT - 1];
    return p;
}

INLINE void code_vertices(const stp_patch *patches, uint32_t count, stp_sample *samples, coder c)
{
    parts previous = {{0}};
    for (uint32_t i = 0; i < count; i++) {
        parts predicted = vertex_prediction(&patches[i], &previous);
        parts p = {{0}};
        if (!c.decode)
            p = sample_unpack(&samples[i]);
        code(&c, STP_COLUMN_RADIUS, RADIUS, predicted.v[RADIUS], &p);
        code(&c, STP_COLUMN_FLAGS, FLAGS, predicted.v[FLAGS], &p);
        code(&c, STP_COLUMN_CLASS, CLASS, predicted.v[CLASS], &p);
        code_normal(&c, &predicted, &p);
        code_colours(&c, &predicted, false, &p);
        plane on = plane_of(stp_integer_normal(p.v[NU], p.v[NV]));
        c.origin = patches[i].origin;
        code_position(&c, &predicted, &on, true, &p);
        if (c.decode)
            sample_pack(&p, &samples[i]);
        previous = p;
        c.cells++;
    }
}

void stp_predict_vertices_encode(const stp_chunk *chunk, const stp_table *table)
{
    code_vertices(chunk->patches, chunk->patch_count, chunk->samples[STP_LEVEL_COUNT - 1],
                  table_coder(table, false));
}

void stp_predict_vertices_decode(stp_chunk *chunk, const stp_table *table)
{
    code_vertices(chunk->patches, chunk->patch_count, chunk->samples[STP_LEVEL_COUNT - 1],
                  table_coder(table, true));
}

/* ---- levels 2 to 0 ---- */

/* Weight by radius code difference: 1024 * 2^(-code / 8), rounded; the area of a disc relative to
 * the largest one. WEIGHT_COUNT values; the last is for all greater differences. */
#define WEIGHT_COUNT 89
static const int16_t area_weight[WEIGHT_COUNT] = {
    1024, 939, 861, 790, 724, 664, 609, 558, 512, 470, 431, 395, 362, 332, 304, 279, 256, 235,
    215,  197, 181, 166, 152, 140, 128, 117, 108, 99,  91,  83,  76,  70,  64,  59,  54,  49,
    45,   41,  38,  35,  32,  29,  27,  25,  23,  21,  19,  17,  16,  15,  13,  12,  11,  10,
    10,   9,   8,   7,   7,   6,   6,   5,   5,   4,   4,   4,   3,   3,   3,   3,   2,   2,
    2,    2,   2,   2,   1,   1,   1,   1,   1,   1,   1,   1,   1,   1,   1,   1,   1};

/* A parent, its children, and what the children coded so far leave of the parent's mean. */
typedef struct family {
    parts parent;
    plane plane;
    stp_sample *children;
    const stp_corner *corners; /* of the children; NULL: all are told */
    unsigned count;
    int32_t weight[4];
    int32_t weight_all, weight_left;
    int32_t moment[MEAN_COUNT]; /* sum over elder children of weight * (parent - child) */
    stp_family_normals normals;
} family;

INLINE void family_begin(family *f, stp_sample *children, const stp_corner *corners, unsigned count)
{
    int greatest = 0;
    f->children = children;
    f->corners = corners;
    f->count = count;
    f->weight_left = 0;
    for (unsigned k = 0; k < count; k++)
        greatest = children[k].radius > greatest ? children[k].radius : greatest;
    for (unsigned k = 0; k < count; k++) {
        int below = greatest - children[k].radius;
        f->weight[k] = area_weight[below < WEIGHT_COUNT ? below : WEIGHT_COUNT - 1];
        f->weight_left += f->weight[k];
    }
    f->weight_all = f->weight_left;
    for (int i = 0; i < MEAN_COUNT; i++)
        f->moment[i] = 0;
    f->normals.sum = (stp_ivec3){{0, 0, 0}};
    f->normals.turned = (stp_ivec3){{0, 0, 0}};
}

/* The mean of the children that are left, if the parent is the weighted mean of all children. */
INLINE void family_predict(const family *f, parts *out)
{
    *out = f->parent;
    if (f->weight_left == f->weight_all)
        return;
    divisor d = divisor_of(f->weight_left);
#pragma GCC unroll 16
    for (int i = 0; i < MEAN_COUNT; i++)
        out->v[i] = (f->parent.v[i] + divide(f->moment[i], d)) & component_mask[i];
}

/* Predicts the normal. The position is known by then. */
INLINE void family_predict_normal(family *f, unsigned k, bool youngest, const stp_turning *turning,
                                  const parts *p, parts *out)
{
    if (youngest) {
        if (f->count > 1)
            stp_direction_code(stp_last_direction(&f->normals, f->weight[k]), &out->v[NU]);
        return;
    }
    int32_t offset[3];
    for (int i = 0; i < 3; i++)
        offset[i] = p->v[PX + i] - f->parent.v[PX + i];
    stp_ivec3 turn = stp_turning_over(turning, offset);
    stp_direction_code(stp_elder_direction(&f->normals, f->weight_all, f->weight_left, turn),
                       &out->v[NU]);
    for (int i = 0; i < 3; i++)
        f->normals.turned.v[i] += f->weight[k] * turn.v[i];
}

INLINE void family_take(family *f, unsigned k, const parts *child)
{
    f->weight_left -= f->weight[k];
#pragma GCC unroll 16
    for (int i = 0; i < MEAN_COUNT; i++)
        f->moment[i] += f->weight[k] * (f->parent.v[i] - child->v[i]);
    stp_ivec3 unit = stp_unit_normal(stp_integer_normal(child->v[NU], child->v[NV]));
    for (int i = 0; i < 3; i++)
        f->normals.sum.v[i] += f->weight[k] * unit.v[i];
}

/* Codes one child, or recalls it. `youngest` is a constant in each caller, as c->decode is. */
INLINE void code_child(family *f, unsigned k, bool youngest, const stp_turning *turning, coder *c)
{
    parts predicted;
    parts p = {{0}};
    const bool told = !f->corners || f->corners[k].ago == 0;
    if (!told && c->decode)
        f->children[k] = stp_corner_recall(c->block, f->corners[k], c->patch);
    if (told && c->decode)
        p.v[RADIUS] = f->children[k].radius;
    else
        p = sample_unpack(&f->children[k]);
    family_predict(f, &predicted);
    if (told) {
        code(c, STP_COLUMN_FLAGS, FLAGS, predicted.v[FLAGS], &p);
        code(c, STP_COLUMN_CLASS, CLASS, predicted.v[CLASS], &p);
        code_colours(c, &predicted, youngest, &p);
        code_position(c, &predicted, &f->plane, youngest, &p);
    }
    family_predict_normal(f, k, youngest, turning, &p, &predicted);
    if (told)
        code_normal(c, &predicted, &p);
    if (!youngest)
        family_take(f, k, &p);
    if (!told)
        return;
    if (c->decode)
        sample_pack(&p, &f->children[k]);
    c->cells++;
}

INLINE void code_family(family *f, const stp_turning *turning, coder *elder, coder *last)
{
    for (unsigned k = 0; k + 1 < f->count; k++)
        code_child(f, k, false, turning, elder);
    code_child(f, f->count - 1, true, turning, last);
}

/* Codes the children of parents that are siblings: the parents' normals tell how the surface turns.
 */
INLINE void code_siblings(const stp_sample *parents, unsigned count, stp_sample *children,
                          const stp_corner *corners, const unsigned *begin, coder *elder,
                          coder *last)
{
    family families[4];
    stp_siblings siblings = {.count = count};
    stp_turning turning;
    for (unsigned j = 0; j < count; j++) {
        family *f = &families[j];
        f->parent = sample_unpack(&parents[j]);
        stp_ivec3 normal = stp_integer_normal(f->parent.v[NU], f->parent.v[NV]);
        f->plane = plane_of(normal);
        f->normals.parent = stp_unit_normal(normal);
        siblings.normal[j] = f->normals.parent;
        for (int i = 0; i < 3; i++)
            siblings.position[j].v[i] = f->parent.v[PX + i];
    }
    stp_turning_fit(&siblings, &turning);
    for (unsigned j = 0; j < count; j++) {
        family_begin(&families[j], children + begin[j], corners ? corners + begin[j] : NULL,
                     begin[j + 1] - begin[j]);
        code_family(&families[j], &turning, elder, last);
    }
}

/* Codes a radius by places on the grid of radii. */
INLINE void code_radius(const coder *c, int32_t predicted, parts *p)
{
    int16_t *residual = c->cells + (size_t)STP_COLUMN_RADIUS * c->stride;
    const unsigned shift = c->radius_shift;
    const int32_t place = (predicted - 1 + (1 << shift >> 1)) >> shift;
    if (c->decode)
        p->v[RADIUS] = ((place + *residual) * (1 << shift) + 1) & 0xff;
    else
        *residual = wrap(((p->v[RADIUS] - 1) >> shift) - place, 0xff);
}

/* Codes the radii of one patch's level first, because they are the weights of all other fields.
 * Each is predicted from a running mean of the radii before (in sixteenths). */
INLINE void code_radii(stp_sample *samples, const stp_corner *corners, unsigned count,
                       unsigned finer, int32_t first, coder *elder, coder *last)
{
    parts p = {{0}};
    int32_t mean = 16 * first;
    for (unsigned j = 0; j < count; j++) {
        unsigned begin = stp_level_children_begin(j, count, finer);
        unsigned end = stp_level_children_begin(j + 1, count, finer);
        for (unsigned k = begin; k < end; k++) {
            coder *c = k + 1 < end ? elder : last;
            const bool told = !corners || corners[k].ago == 0;
            if (!told && c->decode)
                samples[k].radius = stp_corner_recall(c->block, corners[k], c->patch).radius;
            p.v[RADIUS] = samples[k].radius;
            if (told)
                code_radius(c, (mean + 8) >> 4, &p);
            if (c->decode)
                samples[k].radius = (uint8_t)p.v[RADIUS];
            mean = (mean + 16 * p.v[RADIUS]) >> 1;
            c->cells += told;
        }
    }
}

/* Codes a level, siblings by siblings. At level 3 each sample is alone: one a patch. */
INLINE void code_level(const stp_chunk *chunk, int level, const uint8_t *sublattices,
                       const stp_corner *all_corners, coder elder, coder last)
{
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        const stp_patch *patch = &chunk->patches[i];
        unsigned count = patch->counts[level + 1];
        unsigned finer = patch->counts[level];
        unsigned groups = stp_level_count_above(count);
        stp_sample *samples = chunk->samples[level] + chunk->level_begin[level][i];
        const stp_sample *parents = chunk->samples[level + 1] + chunk->level_begin[level + 1][i];
        elder.patch_scale = stp_scale_of_patch(&elder.scale, patch);
        last.patch_scale = stp_scale_of_patch(&last.scale, patch);
        elder.sublattice = last.sublattice = sublattices ? sublattices[i] : 0;
        elder.origin = last.origin = patch->origin;
        elder.block = last.block = chunk;
        elder.patch = last.patch = patch;
        const stp_corner *corners = all_corners ? all_corners + chunk->level_begin[0][i] : NULL;
        coder elder_radii = elder;
        coder last_radii = last;
        code_radii(samples, corners, count, finer, patch->radius[level], &elder_radii, &last_radii);
        for (unsigned g = 0; g < groups; g++) {
            unsigned first = stp_level_children_begin(g, groups, count);
            unsigned end = stp_level_children_begin(g + 1, groups, count);
            unsigned begin[5];
            for (unsigned j = first; j <= end; j++)
                begin[j - first] = stp_level_children_begin(j, count, finer);
            code_siblings(parents + first, end - first, samples, corners, begin, &elder, &last);
        }
    }
}

void stp_predict_row_counts(const stp_chunk *chunk, int level, uint32_t *elder, uint32_t *last)
{
    *last = chunk->level_begin[level + 1][chunk->patch_count];
    *elder = chunk->level_begin[level][chunk->patch_count] - *last;
}

void stp_predict_row_kinds(const stp_chunk *chunk, int level, const stp_corner *corners,
                           uint8_t *elder, uint8_t *last)
{
    const stp_sample *parent = chunk->samples[level + 1];
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        const unsigned count = chunk->patches[i].counts[level + 1];
        const unsigned finer = chunk->patches[i].counts[level];
        unsigned begin = 0;
        for (unsigned j = 1; j <= count; j++) {
            const unsigned end = stp_level_children_begin(j, count, finer);
            const uint8_t kind = stp_row_kind_of(0, parent++->flags);
            for (unsigned left = end - begin; left-- > 0;) {
                if (corners && corners++->ago > 0)
                    continue;
                if (left > 0)
                    *elder++ = (uint8_t)(kind | left);
                else
                    *last++ = kind;
            }
            begin = end;
        }
    }
}

void stp_predict_level_encode(const stp_chunk *chunk, int level, const stp_level_tables *tables)
{
    code_level(chunk, level, tables->elder.sublattices, tables->corners.of,
               table_coder(&tables->elder, false), table_coder(&tables->last, false));
}

void stp_predict_level_decode(stp_chunk *chunk, int level, const stp_level_tables *tables)
{
    const uint8_t *sublattices = tables->elder.sublattices;
    const coder elder = table_coder(&tables->elder, true), last = table_coder(&tables->last, true);
    if (tables->corners.of)
        code_level(chunk, level, sublattices, tables->corners.of, elder, last);
    else /* without any look at corners */
        code_level(chunk, level, sublattices, NULL, elder, last);
}
