/* Codes samples as byte planes, family beside family. */
#include "formats/chunk/codec/predict/families.h"

#include "formats/chunk/codec/predict/predict_normal.h"
#include "formats/chunk/sample/normal_grid.h"

#include <stdlib.h>
#include <string.h>

#define INLINE STP_INLINE
/* Families computed at once: as many as caches hold, in whole patches. */
#define LANES 64u
#define VECTOR STP_FAMILY_SLACK /* lanes of the widest vectors that we count on */

/* Components of a sample. Those whose parent is the mean of its children come first. Positions are
 * along the patch's axes: C is the axis of the greatest component of its cone's axis. */
enum { PA, PB, PC, NU, NV, RED, GREEN, BLUE, INTENSITY, CLASS, FLAGS, RADIUS, COMPONENT_COUNT };
#define MEAN_COUNT CLASS
/* Slopes divide by at least this much of a normal's component along C. */
#define SLOPE_LEAST 1024

typedef int32_t lane[LANES];
typedef float float_lane[LANES];

/* A run of families of whole patches, so that siblings are together. */
typedef struct families {
    uint32_t count;
    uint32_t lanes; /* lanes computed: count, for decoding rounded up to whole vectors */
    bool has_colour, has_intensity; /* if false, all values are 0 and are not computed */
    lane parent[COMPONENT_COUNT];
    lane child[STP_FAMILY_SLOTS][COMPONENT_COUNT];
    lane children; /* how many */
    lane axis;     /* which axis is C */
    float_lane weight[STP_FAMILY_SLOTS];
    float_lane left;               /* weights of the slots not coded yet */
    float_lane moment[MEAN_COUNT]; /* sum over coded slots of weight * (parent - child) */
    float_lane slope_a, slope_b;   /* of the plane across the parent's normal: C by A and B */
    lane predicted[MEAN_COUNT], residual[3];
    float_lane mean_weight;
    uint32_t texel[STP_FAMILY_SLOTS][LANES][4];
} families;

/* The planes of a level at the first family of a run. */
typedef struct plane_cursor {
    uint8_t *const *parts;
    size_t stride;        /* families of the level */
    size_t first;         /* of the run */
    stp_normal_grid grid; /* that all normals are on */
    bool decode;          /* a constant in each caller, so the compiler makes two straight loops */
} plane_cursor;

size_t stp_families_scratch_bytes(void)
{
    return sizeof(families);
}

uint32_t stp_families_count(const stp_chunk *chunk, int level)
{
    return chunk->level_begin[level + 1][chunk->patch_count];
}

size_t stp_families_plane_bytes(const stp_chunk *chunk, int level)
{
    return (size_t)STP_FAMILY_PLANES * STP_FAMILY_SLOTS * stp_families_count(chunk, level);
}

/* ---- samples to lanes and back ---- */

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "samples are read and written as words");
typedef uint32_t word __attribute__((may_alias, aligned(2)));

/* Chooses by axis 0, 1 or 2, without a branch. */
INLINE int32_t choose(int32_t axis, int32_t of_0, int32_t of_1, int32_t of_2)
{
    int32_t is_0 = -(axis == 0), is_1 = -(axis == 1);
    return (of_0 & is_0) | (of_1 & is_1) | (of_2 & ~(is_0 | is_1));
}

/* Consecutive samples into lanes. axis: C of each sample's patch. */
INLINE void samples_to_lanes(const stp_sample *samples, uint32_t count,
                             const int32_t *restrict axis, lane *restrict out)
{
    const word *restrict words = (const word *)(const void *)samples;
    for (size_t i = 0; i < count; i++) {
        uint32_t w0 = words[4 * i], w1 = words[4 * i + 1];
        int32_t x = (int32_t)(w0 & 65535u);
        int32_t y = (int32_t)(w0 >> 16);
        int32_t z = (int32_t)(w1 & 65535u);
        out[PA][i] = choose(axis[i], y, z, x);
        out[PB][i] = choose(axis[i], z, x, y);
        out[PC][i] = choose(axis[i], x, y, z);
        out[RADIUS][i] = (int32_t)(w1 >> 16 & 255u);
        out[FLAGS][i] = (int32_t)(w1 >> 24);
    }
    for (size_t i = 0; i < count; i++) {
        uint32_t w2 = words[4 * i + 2], w3 = words[4 * i + 3];
        out[NU][i] = (int32_t)(w2 & 4095u);
        out[NV][i] = (int32_t)(w2 >> 12 & 4095u);
        out[CLASS][i] = (int32_t)(w2 >> 24);
        out[RED][i] = (int32_t)(w3 & 255u);
        out[GREEN][i] = (int32_t)(w3 >> 8 & 255u);
        out[BLUE][i] = (int32_t)(w3 >> 16 & 255u);
        out[INTENSITY][i] = (int32_t)(w3 >> 24);
    }
}

/* Lanes into rows of four words, a row a sample. */
INLINE void lanes_to_words(const lane *restrict c, uint32_t count, const int32_t *restrict axis,
                           uint32_t *restrict words)
{
    for (size_t i = 0; i < count; i++) {
        int32_t along_a = c[PA][i], along_b = c[PB][i], along_c = c[PC][i];
        int32_t x = choose(axis[i], along_c, along_b, along_a);
        int32_t y = choose(axis[i], along_a, along_c, along_b);
        int32_t z = choose(axis[i], along_b, along_a, along_c);
        words[4 * i] = (uint32_t)x | (uint32_t)y << 16;
        words[4 * i + 1] = (uint32_t)z | (uint32_t)c[RADIUS][i] << 16 | (uint32_t)c[FLAGS][i] << 24;
        words[4 * i + 2] =
            (uint32_t)c[NU][i] | (uint32_t)c[NV][i] << 12 | (uint32_t)c[CLASS][i] << 24;
        words[4 * i + 3] = (uint32_t)c[RED][i] | (uint32_t)c[GREEN][i] << 8 |
                           (uint32_t)c[BLUE][i] << 16 | (uint32_t)c[INTENSITY][i] << 24;
    }
}

/* Slopes of the plane across each parent's normal. */
INLINE void find_slopes(families *restrict f)
{
    for (uint32_t i = 0; i < f->lanes; i++) {
        int32_t x = 2 * f->parent[NU][i] - STP_NORMAL_CODE_MAX;
        int32_t y = 2 * f->parent[NV][i] - STP_NORMAL_CODE_MAX;
        int32_t z = STP_NORMAL_CODE_MAX - abs(x) - abs(y);
        int32_t folded_x = x < 0 ? abs(y) - STP_NORMAL_CODE_MAX : STP_NORMAL_CODE_MAX - abs(y);
        int32_t folded_y = y < 0 ? abs(x) - STP_NORMAL_CODE_MAX : STP_NORMAL_CODE_MAX - abs(x);
        x = z < 0 ? folded_x : x;
        y = z < 0 ? folded_y : y;
        int32_t c = choose(f->axis[i], x, y, z);
        int32_t size = abs(c) > SLOPE_LEAST ? abs(c) : SLOPE_LEAST;
        float along = (float)(c < 0 ? size : -size);
        f->slope_a[i] = (float)choose(f->axis[i], y, z, x) / along;
        f->slope_b[i] = (float)choose(f->axis[i], z, x, y) / along;
    }
}

INLINE int patch_axis(const stp_patch *patch)
{
    uint32_t normal = patch->cone_axis[0] | (uint32_t)patch->cone_axis[1] << 8 |
                      (uint32_t)patch->cone_axis[2] << 16;
    return stp_main_axis(stp_integer_normal((int32_t)(normal & 4095u), (int32_t)(normal >> 12)));
}

/* How many children each parent of a patch has. */
INLINE void count_children(const stp_patch *patch, int level, int32_t *out)
{
    unsigned count = patch->counts[level + 1];
    unsigned finer = patch->counts[level];
    unsigned begin = 0;
    for (unsigned j = 0; j < count; j++) {
        unsigned end =
            finer == 4 * count ? begin + 4 : stp_level_children_begin(j + 1, count, finer);
        out[j] = (int32_t)(end - begin);
        begin = end;
    }
}

/* Takes the parents of patches [begin, end), and computes what follows from them. */
INLINE void take_parents(const stp_chunk *chunk, int level, uint32_t begin, uint32_t end,
                         bool whole_vectors, families *f)
{
    f->count = 0;
    for (uint32_t p = begin; p < end; p++) {
        unsigned count = chunk->patches[p].counts[level + 1];
        int axis = patch_axis(&chunk->patches[p]);
        count_children(&chunk->patches[p], level, f->children + f->count);
        for (unsigned j = 0; j < count; j++)
            f->axis[f->count++] = axis;
    }
    samples_to_lanes(chunk->samples[level + 1] + chunk->level_begin[level + 1][begin], f->count,
                     f->axis, f->parent);
    f->lanes = whole_vectors ? (f->count + VECTOR - 1) / VECTOR * VECTOR : f->count;
    for (uint32_t i = f->count; i < f->lanes; i++) { /* any valid values */
        f->axis[i] = 0;
        f->children[i] = 1;
        for (int c = 0; c < COMPONENT_COUNT; c++)
            f->parent[c][i] = 0;
    }
    find_slopes(f);
}

/* Takes the children into their slots: elder ones from 0 on, the last in 3. */
INLINE void take_children(const stp_chunk *chunk, int level, uint32_t begin, families *f)
{
    const stp_sample *next = chunk->samples[level] + chunk->level_begin[level][begin];
    memset(f->texel, 0, sizeof f->texel);
    for (uint32_t i = 0; i < f->count; i++)
        for (int32_t k = 1; k <= f->children[i]; k++)
            memcpy(f->texel[k == f->children[i] ? 3 : k - 1][i], next++, sizeof *next);
    for (unsigned k = 0; k < STP_FAMILY_SLOTS; k++)
        samples_to_lanes((const stp_sample *)(const void *)f->texel[k], f->count, f->axis,
                         f->child[k]);
}

INLINE void give_children(stp_chunk *chunk, int level, uint32_t begin, families *f)
{
    stp_sample *next = chunk->samples[level] + chunk->level_begin[level][begin];
    for (unsigned k = 0; k < STP_FAMILY_SLOTS; k++)
        lanes_to_words(f->child[k], f->lanes, f->axis, &f->texel[k][0][0]);
    const stp_sample *end = chunk->samples[level] + chunk->level_begin[level][chunk->patch_count];
    uint32_t i = 0;
    /* If there is room, writes empty slots, too: the next family overwrites them. */
    for (; i < f->count && end - next >= (ptrdiff_t)STP_FAMILY_SLOTS; i++) {
        memcpy(next, f->texel[0][i], sizeof *next);
        memcpy(next + 1, f->texel[1][i], sizeof *next);
        memcpy(next + 2, f->texel[2][i], sizeof *next);
        next += f->children[i];
        memcpy(next - 1, f->texel[3][i], sizeof *next);
    }
    for (; i < f->count; i++) {
        for (int32_t k = 1; k < f->children[i]; k++)
            memcpy(next++, f->texel[k - 1][i], sizeof *next);
        memcpy(next++, f->texel[3][i], sizeof *next);
    }
}

/* ---- residuals ---- */

/* Rounds to nearest, halves up. The limits lie at a position's range; beyond it the result makes no
 * difference. */
INLINE int32_t nearest(float value)
{
    value = value < 65535.0f ? value : 65535.0f;
    value = value > -65535.0f ? value : -65535.0f;
    return (int32_t)(value + 65536.5f) - 65536;
}

/* Signed to unsigned of small magnitude: 0, -1, 1, -2, 2 become 0, 1, 2, 3, 4. */
INLINE uint32_t fold(int32_t value)
{
    return (uint32_t)value << 1 ^ (value < 0 ? UINT32_MAX : 0u);
}

INLINE int32_t unfold(uint32_t folded)
{
    return (int32_t)(folded >> 1) ^ -(int32_t)(folded & 1u);
}

INLINE uint8_t *plane_of(const plane_cursor *c, int plane, unsigned slot)
{
    return slot == 3 ? c->parts[STP_FAMILY_PLANES + plane] + c->first
                     : c->parts[plane] + slot * c->stride + c->first;
}

INLINE void code_bytes(const plane_cursor *c, int plane, unsigned slot, uint32_t count,
                       const int32_t *restrict predicted, int32_t *restrict value)
{
    uint8_t *restrict bytes = plane_of(c, plane, slot);
    for (uint32_t i = 0; i < count; i++) {
        if (c->decode)
            value[i] = (predicted[i] + bytes[i]) & 255;
        else
            bytes[i] = (uint8_t)(value[i] - predicted[i]);
    }
}

INLINE void code_shorts(const plane_cursor *c, int plane, unsigned slot, uint32_t count,
                        const int32_t *restrict predicted, int32_t *restrict value,
                        int32_t *restrict residual)
{
    uint8_t *restrict low = plane_of(c, plane, slot);
    uint8_t *restrict high = plane_of(c, plane + 1, slot);
    for (uint32_t i = 0; i < count; i++) {
        if (c->decode) {
            residual[i] = unfold((uint32_t)low[i] | (uint32_t)high[i] << 8);
            value[i] = (predicted[i] + residual[i]) & 65535;
        } else {
            residual[i] = (int16_t)(value[i] - predicted[i]);
            uint32_t folded = fold(residual[i]);
            low[i] = (uint8_t)folded;
            high[i] = (uint8_t)(folded >> 8);
        }
    }
}

/* 12 bits, the value of least magnitude. */
INLINE int32_t wrap_normal(int32_t difference)
{
    return (int32_t)((uint32_t)difference << 20) >> 20;
}

INLINE void code_normals(const plane_cursor *c, unsigned slot, uint32_t count,
                         const lane *restrict predicted, lane *restrict value)
{
    uint8_t *restrict u = plane_of(c, STP_PLANE_NORMAL_U, slot);
    uint8_t *restrict v = plane_of(c, STP_PLANE_NORMAL_V, slot);
    uint8_t *restrict high = plane_of(c, STP_PLANE_NORMAL_HIGH, slot);
    for (uint32_t i = 0; i < count; i++) {
        if (c->decode) {
            uint32_t top = high[i];
            value[NU][i] = (predicted[NU][i] + unfold(u[i] | (top & 15u) << 8)) & 4095;
            value[NV][i] = (predicted[NV][i] + unfold(v[i] | (top >> 4) << 8)) & 4095;
        } else {
            uint32_t fu = fold(wrap_normal(value[NU][i] - predicted[NU][i]));
            uint32_t fv = fold(wrap_normal(value[NV][i] - predicted[NV][i]));
            u[i] = (uint8_t)fu;
            v[i] = (uint8_t)fv;
            high[i] = (uint8_t)(fu >> 8 | fv >> 8 << 4);
        }
    }
}

/* The nearest place on the grid to a prediction. */
INLINE int32_t place_of(int32_t predicted, const stp_normal_grid *grid)
{
    predicted = predicted > 0 ? predicted : 0;
    return stp_normal_place_near(grid, predicted < 4095 ? predicted : 4095);
}

/* The same by places on a grid. */
INLINE void code_places(const plane_cursor *c, unsigned slot, uint32_t count,
                        const lane *restrict predicted, lane *restrict value)
{
    const stp_normal_grid grid = c->grid;
    uint8_t *restrict u = plane_of(c, STP_PLANE_NORMAL_U, slot);
    uint8_t *restrict v = plane_of(c, STP_PLANE_NORMAL_V, slot);
    uint8_t *restrict high = plane_of(c, STP_PLANE_NORMAL_HIGH, slot);
    for (uint32_t i = 0; i < count; i++) {
        int32_t pu = place_of(predicted[NU][i], &grid), pv = place_of(predicted[NV][i], &grid);
        if (c->decode) {
            uint32_t top = high[i];
            int32_t nu = (pu + unfold(u[i] | (top & 15u) << 8)) & 4095;
            int32_t nv = (pv + unfold(v[i] | (top >> 4) << 8)) & 4095;
            value[NU][i] = stp_normal_code_at(&grid, nu);
            value[NV][i] = stp_normal_code_at(&grid, nv);
        } else {
            int32_t nu = stp_normal_place_of(&grid, value[NU][i]);
            int32_t nv = stp_normal_place_of(&grid, value[NV][i]);
            uint32_t fu = fold(wrap_normal(nu - pu)), fv = fold(wrap_normal(nv - pv));
            u[i] = (uint8_t)fu;
            v[i] = (uint8_t)fv;
            high[i] = (uint8_t)(fu >> 8 | fv >> 8 << 4);
        }
    }
}

/* ---- prediction ---- */

/* Weight by radius code difference: 1024 * 2^(-code / 8), rounded; the area of a disc relative to
 * the largest one. WEIGHT_COUNT values; the last is for all greater differences. */
#define WEIGHT_COUNT 89
#define NO_WEIGHT WEIGHT_COUNT /* of an empty slot */
static const float area_weight[WEIGHT_COUNT + 1] = {
    1024, 939, 861, 790, 724, 664, 609, 558, 512, 470, 431, 395, 362, 332, 304, 279, 256, 235,
    215,  197, 181, 166, 152, 140, 128, 117, 108, 99,  91,  83,  76,  70,  64,  59,  54,  49,
    45,   41,  38,  35,  32,  29,  27,  25,  23,  21,  19,  17,  16,  15,  13,  12,  11,  10,
    10,   9,   8,   7,   7,   6,   6,   5,   5,   4,   4,   4,   3,   3,   3,   3,   2,   2,
    2,    2,   2,   2,   1,   1,   1,   1,   1,   1,   1,   1,   1,   1,   1,   1,   1,   0};

/* Codes the radii of all slots and computes their weights. */
INLINE void code_radii(const plane_cursor *c, families *f)
{
    lane greatest = {0}, lost;
    uint32_t n = f->lanes;
    for (unsigned k = 0; k < STP_FAMILY_SLOTS; k++)
        code_bytes(c, STP_PLANE_RADIUS, k, n, f->parent[RADIUS], f->child[k][RADIUS]);
    for (int32_t k = 0; k < (int32_t)STP_FAMILY_SLOTS; k++)
        for (uint32_t i = 0; i < n; i++) {
            int32_t radius = f->child[k][RADIUS][i];
            radius = k == 3 || k + 1 < f->children[i] ? radius : 0;
            greatest[i] = radius > greatest[i] ? radius : greatest[i];
        }
    memset(f->left, 0, sizeof f->left);
    for (int32_t k = 0; k < (int32_t)STP_FAMILY_SLOTS; k++) {
        for (uint32_t i = 0; i < n; i++) {
            int32_t below = greatest[i] - f->child[k][RADIUS][i];
            below = below < WEIGHT_COUNT ? below : WEIGHT_COUNT - 1;
            lost[i] = k == 3 || k + 1 < f->children[i] ? below : NO_WEIGHT;
        }
        for (uint32_t i = 0; i < n; i++)
            f->weight[k][i] = area_weight[lost[i]];
        for (uint32_t i = 0; i < n; i++)
            f->left[i] += f->weight[k][i];
    }
}

INLINE void add_rest(uint32_t count, const int32_t *restrict parent, const float *restrict moment,
                     const float *restrict mean_weight, int32_t *restrict predicted)
{
    for (uint32_t i = 0; i < count; i++)
        predicted[i] = parent[i] + nearest(moment[i] * mean_weight[i]);
}

INLINE void take_moment(uint32_t count, const float *restrict weight,
                        const int32_t *restrict parent, const int32_t *restrict child,
                        float *restrict moment)
{
    for (uint32_t i = 0; i < count; i++)
        moment[i] += weight[i] * (float)(parent[i] - child[i]);
}

/* Whether a component whose parent is the mean has to be computed. */
INLINE bool has(const families *f, int component)
{
    return component < RED || (component < INTENSITY ? f->has_colour : f->has_intensity);
}

/* Predicts from what the slots coded so far leave of the parent's mean. */
INLINE void predict_rest(families *f, unsigned slot)
{
    uint32_t n = f->lanes;
    for (uint32_t i = 0; i < n; i++)
        f->mean_weight[i] = 1.0f / f->left[i];
    if (slot == 0) {
        memcpy(f->predicted, f->parent, sizeof f->predicted);
        return;
    }
    for (int c = 0; c < MEAN_COUNT; c++)
        if (has(f, c))
            add_rest(n, f->parent[c], f->moment[c], f->mean_weight, f->predicted[c]);
}

/* Codes colours. Red and blue of elder children are predicted with the residual of green. */
INLINE void code_colours(const plane_cursor *c, families *f, unsigned slot, bool last)
{
    uint32_t n = f->lanes;
    lane *child = f->child[slot];
    if (f->has_intensity)
        code_bytes(c, STP_PLANE_INTENSITY, slot, n, f->predicted[INTENSITY], child[INTENSITY]);
    if (!f->has_colour)
        return;
    code_bytes(c, STP_PLANE_GREEN, slot, n, f->predicted[GREEN], child[GREEN]);
    for (uint32_t i = 0; !last && i < n; i++) {
        int32_t moved = child[GREEN][i] - f->predicted[GREEN][i];
        f->predicted[RED][i] += moved;
        f->predicted[BLUE][i] += moved;
    }
    code_bytes(c, STP_PLANE_RED, slot, n, f->predicted[RED], child[RED]);
    code_bytes(c, STP_PLANE_BLUE, slot, n, f->predicted[BLUE], child[BLUE]);
}

/* Codes one slot. `last` is a constant in each caller, as c->decode is. */
INLINE void code_slot(const plane_cursor *c, families *f, unsigned slot, bool last)
{
    uint32_t n = f->lanes;
    lane *child = f->child[slot];
    code_bytes(c, STP_PLANE_FLAGS, slot, n, f->parent[FLAGS], child[FLAGS]);
    code_bytes(c, STP_PLANE_CLASS, slot, n, f->parent[CLASS], child[CLASS]);
    predict_rest(f, slot);
    code_colours(c, f, slot, last);
    code_shorts(c, STP_PLANE_A_LOW, slot, n, f->predicted[PA], child[PA], f->residual[PA]);
    code_shorts(c, STP_PLANE_B_LOW, slot, n, f->predicted[PB], child[PB], f->residual[PB]);
    for (uint32_t i = 0; !last && i < n; i++)
        f->predicted[PC][i] += nearest(f->slope_a[i] * (float)f->residual[PA][i] +
                                       f->slope_b[i] * (float)f->residual[PB][i]);
    code_shorts(c, STP_PLANE_C_LOW, slot, n, f->predicted[PC], child[PC], f->residual[PC]);
    if (c->grid.step > 1)
        code_places(c, slot, n, f->predicted, child);
    else
        code_normals(c, slot, n, f->predicted, child);
    for (int m = 0; !last && m < MEAN_COUNT; m++)
        if (has(f, m))
            take_moment(n, f->weight[slot], f->parent[m], child[m], f->moment[m]);
    for (uint32_t i = 0; !last && i < n; i++)
        f->left[i] -= f->weight[slot][i];
}

INLINE void clear_empty(const plane_cursor *c, const families *f)
{
    for (int p = 0; !c->decode && p < STP_FAMILY_PLANES; p++)
        for (int32_t k = 0; k < 3; k++) {
            uint8_t *bytes = plane_of(c, p, (unsigned)k);
            for (uint32_t i = 0; i < f->count; i++)
                bytes[i] = k + 1 < f->children[i] ? bytes[i] : 0;
        }
}

/* Whether a component has any value that is not 0, in parents and children or planes. */
INLINE bool is_there(const plane_cursor *c, const families *f, int component, int plane)
{
    uint32_t any = 0;
    for (uint32_t i = 0; i < f->count; i++)
        any |= (uint32_t)f->parent[component][i];
    for (unsigned k = 0; k < STP_FAMILY_SLOTS; k++) {
        const uint8_t *bytes = plane_of(c, plane, k);
        for (uint32_t i = 0; i < f->count; i++)
            any |= c->decode ? bytes[i] : (uint32_t)f->child[k][component][i];
    }
    return any != 0;
}

/* Notes which components are 0 throughout: they stay 0. */
INLINE void begin_run(const plane_cursor *c, families *f)
{
    f->has_intensity = is_there(c, f, INTENSITY, STP_PLANE_INTENSITY);
    f->has_colour = is_there(c, f, GREEN, STP_PLANE_GREEN) || is_there(c, f, RED, STP_PLANE_RED) ||
                    is_there(c, f, BLUE, STP_PLANE_BLUE);
    memset(f->moment, 0, sizeof f->moment);
    for (unsigned k = 0; k < STP_FAMILY_SLOTS; k++) {
        if (!f->has_intensity)
            memset(f->child[k][INTENSITY], 0, sizeof f->child[k][INTENSITY]);
        if (!f->has_colour)
            memset(f->child[k][RED], 0, 3 * sizeof f->child[k][RED]);
    }
}

INLINE void code_run(const plane_cursor *c, families *f)
{
    begin_run(c, f);
    code_radii(c, f);
    for (unsigned k = 0; k < 3; k++)
        code_slot(c, f, k, false);
    code_slot(c, f, 3, true);
    clear_empty(c, f);
}

/* The end of the patches, from `begin` on, whose families fit into the lanes. */
INLINE uint32_t run_end(const stp_chunk *chunk, int level, uint32_t begin)
{
    uint32_t end = begin;
    uint32_t count = 0;
    while (end < chunk->patch_count && count + chunk->patches[end].counts[level + 1] <= LANES)
        count += chunk->patches[end++].counts[level + 1];
    return end;
}

INLINE void decode_level(stp_chunk *chunk, int level, unsigned step, const uint8_t *const *parts,
                         families *f)
{
    /* Decoding only reads the parts. */
    plane_cursor c = {(uint8_t *const *)(uintptr_t)parts, stp_families_count(chunk, level), 0,
                      stp_normal_grid_of(step), true};
    for (uint32_t begin = 0, end; begin < chunk->patch_count; begin = end) {
        end = run_end(chunk, level, begin);
        take_parents(chunk, level, begin, end, true, f);
        code_run(&c, f);
        give_children(chunk, level, begin, f);
        c.first += f->count;
    }
}

#ifdef __x86_64__
/* The same for processors with wider registers, with the same results. */
__attribute__((target("avx2"))) static void decode_level_wide(stp_chunk *chunk, int level,
                                                              unsigned step,
                                                              const uint8_t *const *parts,
                                                              families *f)
{
    decode_level(chunk, level, step, parts, f);
}

#define AVX512 "avx512f,avx512bw,avx512dq,avx512vl"
#ifdef __clang__
__attribute__((target(AVX512))) static void
#else
__attribute__((target(AVX512 ",prefer-vector-width=512"))) static void
#endif
decode_level_widest(stp_chunk *chunk, int level, unsigned step, const uint8_t *const *parts,
                    families *f)
{
    decode_level(chunk, level, step, parts, f);
}

static bool has_avx512(void)
{
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
#endif

void stp_families_decode(stp_chunk *chunk, int level, unsigned normal_step,
                         const uint8_t *const *parts, void *scratch)
{
#ifdef __x86_64__
    if (has_avx512()) {
        decode_level_widest(chunk, level, normal_step, parts, scratch);
        return;
    }
    if (__builtin_cpu_supports("avx2")) {
        decode_level_wide(chunk, level, normal_step, parts, scratch);
        return;
    }
#endif
    decode_level(chunk, level, normal_step, parts, scratch);
}

void stp_families_encode(const stp_chunk *chunk, int level, unsigned normal_step,
                         uint8_t *const *parts, void *scratch)
{
    families *f = scratch;
    plane_cursor c = {parts, stp_families_count(chunk, level), 0, stp_normal_grid_of(normal_step),
                      false};
    for (uint32_t begin = 0, end; begin < chunk->patch_count; begin = end) {
        end = run_end(chunk, level, begin);
        take_parents(chunk, level, begin, end, false, f);
        take_children(chunk, level, begin, f);
        code_run(&c, f);
        c.first += f->count;
    }
}
