/* Checks patch headers, and turns them into columns of small numbers and back. */
#include "formats/chunk/sample/patch.h"

#include "formats/chunk/codec/predict/predict_normal.h"
#include "formats/chunk/codec/predict/predict_origin.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/normal_grid.h"

#include <inttypes.h>
#include <string.h>

STP_INLINE uint8_t greatest_of(const uint8_t values[STP_PATCH_QUARTERS])
{
    uint8_t greatest = 0;
    for (int q = 0; q < STP_PATCH_QUARTERS; q++)
        greatest = values[q] > greatest ? values[q] : greatest;
    return greatest;
}

/* A level's error must be the greatest of its quarters. A quarter that does not exist must have
 * none. */
static const char *quarter_fault(const stp_patch *patch)
{
    for (int level = 1; level <= 2; level++) {
        const uint8_t *errors = patch->quarter_error[level - 1];
        const uint8_t *tangential = patch->quarter_tangential_error[level - 1];
        if (greatest_of(errors) != patch->error[level] ||
            greatest_of(tangential) != patch->tangential_error[level])
            return "an error of a level is not the greatest of its quarters";
        for (unsigned q = patch->counts[2]; q < STP_PATCH_QUARTERS; q++)
            if (errors[q] || tangential[q])
                return "a quarter that does not exist has an error";
    }
    return NULL;
}

/* Whether all quarters choose the same level, because each has the errors of its level. */
static bool is_whole(const stp_patch *patch)
{
    for (int level = 1; level <= 2; level++)
        for (unsigned q = 0; q < patch->counts[2]; q++)
            if (stp_quarter_error(patch, level, q) != patch->error[level] ||
                stp_quarter_tangential_error(patch, level, q) != patch->tangential_error[level])
                return false;
    return true;
}

/* Checks flags, child, counts and errors of strips and triangles. */
static const char *shape_fault(const stp_patch *patch)
{
    const bool strip = patch->flags & STP_PATCH_STRIP;
    if (patch->flags & STP_PATCH_JOINTS && (!strip || patch->counts[0] < 2))
        return "it continues a strip and is no strip of two vertices or more";
    if (!(patch->flags & STP_PATCH_SHAPES))
        return NULL;
    if (strip && patch->flags & STP_PATCH_TRIANGLES)
        return "it is a strip and triangles";
    if (patch->child != STP_PATCH_NO_CHILD)
        return "a strip or triangles are refined by a child";
    if (strip && !(patch->flags & STP_PATCH_TWO_SIDED))
        return "it is a strip and not two-sided";
    if (!strip && patch->counts[0] % 3 != 0)
        return "its corners are not three a triangle";
    for (int l = 0; strip && l < STP_LEVEL_COUNT; l++)
        if (patch->tangential_error[l])
            return "a strip has a tangential error";
    return is_whole(patch) ? NULL : "the quarters of a strip or of triangles have unequal errors";
}

/* Returns NULL, or what is wrong with a patch. */
static const char *patch_fault(const stp_patch *patch, uint32_t child_count)
{
    if (patch->counts[0] < 1 || patch->counts[0] > STP_PATCH_SAMPLES)
        return "its level 0 has no sample or more than 64";
    for (int l = 0; l + 1 < STP_LEVEL_COUNT; l++)
        if (patch->counts[l + 1] != stp_level_count_above(patch->counts[l]))
            return "a level's count is not a quarter of the finer one's, rounded up";
    if (patch->exponent < -STP_EXPONENT_LIMIT || patch->exponent > STP_EXPONENT_LIMIT)
        return "its step's exponent is out of range";
    if (patch->child != STP_PATCH_NO_CHILD && patch->child >= child_count)
        return "the child it names does not exist";
    if (patch->flags &
        ~(unsigned)(STP_PATCH_TWO_SIDED | STP_PATCH_SHAPES | STP_PATCH_JOINTS | STP_PATCH_CLOSED))
        return "a reserved flag is set";
    const char *fault = quarter_fault(patch);
    return fault ? fault : shape_fault(patch);
}

stp_status stp_patches_check(const stp_patch *patches, uint32_t patch_count,
                             const uint32_t sample_count[STP_LEVEL_COUNT], uint32_t child_count,
                             stp_error *err)
{
    uint32_t total[STP_LEVEL_COUNT] = {0};
    for (uint32_t i = 0; i < patch_count; i++) {
        const char *fault = patch_fault(&patches[i], child_count);
        if (fault)
            return stp_error_set(err, STP_CORRUPT, "patch %" PRIu32 ": %s", i, fault);
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            total[l] += patches[i].counts[l];
    }
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        if (total[l] != sample_count[l])
            return stp_error_set(err, STP_CORRUPT,
                                 "the patches have %" PRIu32 " samples at level %d, expected "
                                 "%" PRIu32,
                                 total[l], l, sample_count[l]);
    return STP_OK;
}

static const char *kind_fault(const stp_patch *patch, const stp_sample *samples)
{
    const stp_sample_kind first = stp_sample_kind_of(samples);
    const bool strip = patch->flags & STP_PATCH_STRIP;
    if (strip && first != STP_KIND_RIBBON && first != STP_KIND_TUBE)
        return "it is a strip whose vertices are no ribbon and no tube";
    if (!strip && first != STP_KIND_POLYGON)
        return "it is triangles whose corners are no polygon's";
    for (unsigned i = 1; i < patch->counts[0]; i++)
        if (stp_sample_kind_of(&samples[i]) != first)
            return "the samples of a strip or of triangles are of several kinds";
    return NULL;
}

stp_status stp_patches_check_kinds(const stp_chunk *chunk, stp_error *err)
{
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        const stp_patch *patch = &chunk->patches[i];
        const char *fault = patch->flags & STP_PATCH_SHAPES
                                ? kind_fault(patch, chunk->samples[0] + chunk->level_begin[0][i])
                                : NULL;
        if (fault)
            return stp_error_set(err, STP_CORRUPT, "patch %" PRIu32 ": %s", i, fault);
    }
    return STP_OK;
}

void stp_patches_place(stp_chunk *chunk)
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        uint32_t begin = 0;
        for (uint32_t i = 0; i < chunk->patch_count; i++) {
            chunk->level_begin[l][i] = begin;
            begin += chunk->patches[i].counts[l];
        }
    }
}

stp_status stp_patches_take(stp_chunk *chunk, uint32_t child_count, stp_error *err)
{
    uint32_t counts[STP_LEVEL_COUNT];
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        counts[l] = chunk->level_begin[l][chunk->patch_count];
    stp_status status =
        stp_patches_check(chunk->patches, chunk->patch_count, counts, child_count, err);
    if (status == STP_OK)
        stp_patches_place(chunk);
    return status;
}

/* A cursor over the columns of one row. Encoding and decoding run the same code. `decode` is a
 * constant in each caller and everything is inlined, so the compiler makes two straight loops of
 * it. */
typedef struct row_coder {
    const stp_table *table;
    uint32_t row;
    unsigned column;
    bool decode;
} row_coder;

/* Tight tables: how much less the code of a level's radius is, as a rule, than the next coarser
 * one's. A disc for four discs is twice as wide, which is 16 codes. */
static const uint8_t tight_drop[STP_LEVEL_COUNT] = {11, 16, 15, 0};
static const uint8_t no_drop[STP_LEVEL_COUNT] = {0};
/* STP_PATCH_MIDDLE is 2^MIDDLE_BITS. */
#define MIDDLE_BITS 9

/* Two for each axis, behind the exponent's. */
#define ORIGIN_COLUMNS 6u

STP_INLINE int16_t *next_cell(row_coder *c)
{
    return stp_table_column(c->table, c->column++) + c->row;
}

STP_INLINE uint8_t code_byte(row_coder *c, uint8_t predicted, uint8_t value)
{
    int16_t *cell = next_cell(c);
    if (c->decode)
        return (uint8_t)(predicted + *cell);
    *cell = (int16_t)((uint8_t)(value - predicted + 128) - 128); /* -128..127 */
    return value;
}

STP_INLINE uint16_t code_short(row_coder *c, uint16_t predicted, uint16_t value)
{
    int16_t *cell = next_cell(c);
    if (c->decode)
        return (uint16_t)(predicted + *cell);
    *cell = (int16_t)(uint16_t)(value - predicted);
    return value;
}

/* Two cells: the low half, signed, then what is left above it. */
STP_INLINE int32_t code_int(row_coder *c, int32_t predicted, int32_t value)
{
    int16_t *low = next_cell(c);
    int16_t *high = next_cell(c);
    if (c->decode)
        return (int32_t)((uint32_t)predicted + (uint32_t)(int32_t)*low +
                         ((uint32_t)(uint16_t)*high << 16));
    uint32_t difference = (uint32_t)value - (uint32_t)predicted;
    *low = (int16_t)(uint16_t)difference;
    *high = (int16_t)(uint16_t)((difference + 0x8000u) >> 16);
    return value;
}

STP_INLINE void code_normal(row_coder *c, const uint8_t previous[3], uint8_t normal[3])
{
    uint32_t before = previous[0] | (uint32_t)previous[1] << 8 | (uint32_t)previous[2] << 16;
    uint32_t now = normal[0] | (uint32_t)normal[1] << 8 | (uint32_t)normal[2] << 16;
    uint32_t u = code_short(c, before & 4095u, now & 4095u) & 4095u;
    uint32_t v = code_short(c, (uint16_t)(before >> 12), (uint16_t)(now >> 12)) & 4095u;
    uint32_t word = u | v << 12;
    normal[0] = (uint8_t)word;
    normal[1] = (uint8_t)(word >> 8);
    normal[2] = (uint8_t)(word >> 16);
}

/* Predicts level 3 from the previous patch, and each finer level l from the next coarser one, less
 * drop[l]; but level 0 from the previous patch, too, if it is apart. */
STP_INLINE void code_levels(row_coder *c, const uint8_t previous[STP_LEVEL_COUNT],
                            const uint8_t drop[STP_LEVEL_COUNT], bool apart,
                            uint8_t values[STP_LEVEL_COUNT])
{
    uint8_t predicted = previous[STP_LEVEL_COUNT - 1];
    for (int l = STP_LEVEL_COUNT - 1; l >= 0; l--) {
        predicted = (uint8_t)(predicted - drop[l]);
        values[l] = code_byte(c, l == 0 && apart ? previous[0] : predicted, values[l]);
        predicted = values[l];
    }
}

/* Codes the errors of levels 3 and 0 by patch and those of levels 2 and 1 by quarter. Level 2 is
 * predicted from level 3, level 1 from level 2 of the same quarter. A level's greatest error
 * follows from its quarters. previous: the errors of the patch before. */
STP_INLINE void code_errors(row_coder *c, const uint8_t previous[STP_LEVEL_COUNT],
                            unsigned quarter_count, uint8_t values[STP_LEVEL_COUNT],
                            uint8_t quarters[2][STP_PATCH_QUARTERS])
{
    values[3] = code_byte(c, previous[3], values[3]);
    for (int level = 2; level > 0; level--) {
        for (unsigned q = 0; q < STP_PATCH_QUARTERS; q++) {
            uint8_t coarser = level == 2 ? values[3] : quarters[1][q];
            quarters[level - 1][q] =
                code_byte(c, q < quarter_count ? coarser : 0, quarters[level - 1][q]);
        }
        values[level] = greatest_of(quarters[level - 1]);
    }
    values[0] = code_byte(c, c->table->tight ? previous[0] : values[1], values[0]);
}

/* Codes the origin as columns of its own. */
STP_INLINE void code_origin_alone(row_coder *c, const stp_patch *previous, stp_patch *p)
{
    for (int i = 0; i < 3; i++)
        p->origin[i] = code_int(c, stp_predict_origin(previous, p->exponent, i, 0), p->origin[i]);
}

/* Codes the origin by the centres of the two patches' bounding spheres, in the order A, B, C, C
 * being the axis that the surface faces from one to the other; along C both are expected to lie on
 * one plane. */
STP_INLINE void code_origin(row_coder *c, const stp_patch *previous, stp_patch *p)
{
    stp_ivec3 n = {{0, 0, 0}};
    int main_axis = 2;
    int64_t rise = 0;
    if (c->row > 0) {
        const stp_ivec3 before = stp_cone_axis_of(previous), own = stp_cone_axis_of(p);
        for (int i = 0; i < 3; i++)
            n.v[i] = before.v[i] + own.v[i];
        main_axis = stp_main_axis(n);
    }
    for (int k = 1; k <= 3; k++) {
        const int axis = (main_axis + k) % 3;
        uint32_t predicted = 0;
        if (c->row > 0)
            predicted = (uint32_t)stp_predict_origin(previous, p->exponent, axis,
                                                     previous->bound_centre[axis]) -
                        p->bound_centre[axis];
        if (k == 3 && n.v[axis] != 0)
            predicted -= (uint32_t)(uint64_t)(rise / n.v[axis]);
        predicted &= ~UINT32_C(7);
        int16_t *middle = next_cell(c), *rest = next_cell(c);
        p->origin[axis] =
            stp_code_eighths(middle, rest, c->decode, (int32_t)predicted, p->origin[axis]);
        rise += n.v[axis] * (int64_t)(int32_t)((uint32_t)p->origin[axis] - predicted);
    }
}

/* Codes the centre of the bounding sphere. Tight: along x it is expected in the middle, and may be
 * 2 to 64 times as far; along y and z it is expected to be the same. */
STP_INLINE void code_centre(row_coder *c, const stp_patch *previous, stp_patch *p)
{
    uint16_t *centre = p->bound_centre;
    if (!c->table->tight) {
        for (int i = 0; i < 3; i++)
            centre[i] = code_short(c, previous->bound_centre[i], centre[i]);
        return;
    }
    const uint16_t way = (uint16_t)(centre[0] - STP_PATCH_MIDDLE);
    const uint16_t turned =
        code_short(c, 0, (uint16_t)(way >> MIDDLE_BITS | way << (16 - MIDDLE_BITS)));
    centre[0] =
        (uint16_t)(STP_PATCH_MIDDLE + (turned << MIDDLE_BITS | turned >> (16 - MIDDLE_BITS)));
    for (int i = 1; i < 3; i++)
        centre[i] = code_short(c, centre[i - 1], centre[i]);
}

STP_INLINE void code_patch(row_coder *c, const stp_patch *previous, stp_patch *p)
{
    const bool tight = c->table->tight;
    p->exponent = (int16_t)code_short(c, (uint16_t)previous->exponent, (uint16_t)p->exponent);
    row_coder origin = *c; /* comes last, since it follows the cone's axis */
    c->column += ORIGIN_COLUMNS;
    p->child = code_byte(c, previous->child, p->child);
    p->flags = code_byte(c, previous->flags, p->flags);
    p->counts[0] = code_byte(c, tight ? STP_PATCH_SAMPLES : previous->counts[0], p->counts[0]);
    for (int l = 0; l + 1 < STP_LEVEL_COUNT; l++)
        p->counts[l + 1] = (uint8_t)stp_level_count_above(p->counts[l]);
    code_levels(c, previous->radius, tight ? tight_drop : no_drop, false, p->radius);
    code_errors(c, previous->error, p->counts[2], p->error, p->quarter_error);
    code_errors(c, previous->tangential_error, p->counts[2], p->tangential_error,
                p->quarter_tangential_error);
    code_levels(c, previous->colour_error, no_drop, tight, p->colour_error);
    code_centre(c, previous, p);
    p->bound_radius = code_byte(c, p->radius[STP_LEVEL_COUNT - 1], p->bound_radius);
    p->cone_angle = code_byte(c, previous->cone_angle, p->cone_angle);
    code_normal(c, previous->cone_axis, p->cone_axis);
    if (c->column < c->table->column_count) {
        uint16_t next = (uint16_t)(previous->first_below + previous->counts[0]);
        p->first_below = code_short(c, next, p->first_below);
    }
    if (c->table->placed)
        return;
    if (c->table->middles)
        code_origin(&origin, previous, p);
    else
        code_origin_alone(&origin, previous, p);
}

STP_INLINE void code_patches(const stp_patch *in, stp_patch *out, const stp_table *table,
                             bool decode)
{
    stp_patch previous;
    memset(&previous, 0, sizeof previous);
    for (int i = 0; table->middles && i < 3; i++)
        previous.bound_centre[i] = STP_PATCH_MIDDLE;
    if (table->tight)
        previous.child = STP_PATCH_NO_CHILD;
    for (uint32_t i = 0; i < table->row_count; i++) {
        row_coder c = {.table = table, .row = i, .decode = decode};
        stp_patch patch;
        memset(&patch, 0, sizeof patch);
        if (!decode)
            patch = in[i];
        code_patch(&c, &previous, &patch);
        if (decode)
            out[i] = patch;
        previous = patch;
    }
}

void stp_patches_encode(const stp_patch *patches, const stp_table *table)
{
    code_patches(patches, NULL, table, false);
}

void stp_patches_decode(stp_patch *patches, const stp_table *table)
{
    code_patches(NULL, patches, table, true);
}
