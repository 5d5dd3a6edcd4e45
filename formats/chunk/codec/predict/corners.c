/* Corners of triangles that a block has told before. */
#include "formats/chunk/codec/predict/corners.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* Symbols: 0 is a corner that is told. Up to NEAR, a symbol is how many different corners ago its
 * equal came. NEAR + 1 + b stands for 2^b - 1 more than that, plus b plain bits. */
#define NEAR 15u
#define SHIFT 5
/* Symbols 0 to FIRST - 1 begin with odds of their own, in 1/256; all others share the rest. */
#define FIRST 5
#define CONTEXTS 8u
static const uint8_t first_odds[CONTEXTS][FIRST] = {
    {31, 91, 13, 89, 10}, {186, 1, 11, 3, 12}, {4, 1, 248, 1, 1},  {30, 1, 1, 26, 156},
    {2, 1, 250, 1, 1},    {46, 1, 2, 1, 92},   {174, 1, 1, 13, 5}, {226, 1, 1, 1, 1},
};

typedef struct corner_odds {
    stp_odds of[CONTEXTS];
} corner_odds;

/* Which odds a corner has: those of a triangle's first corner, of its second one by how long ago
 * the first came, of its third one by whether both came before. */
static unsigned context_of(const stp_corner *corners, uint32_t begin, uint32_t i)
{
    const unsigned k = (i - begin) % 3;
    const uint32_t before = k > 0 ? corners[i - 1].ago : 0;
    if (k == 0)
        return 0;
    if (k == 1)
        return 1 + (before < 4 ? before : 4);
    return before > 0 && corners[i - 2].ago > 0 ? 7 : 6;
}

static void odds_begin(corner_odds *odds)
{
    for (unsigned c = 0; c < CONTEXTS; c++) {
        int16_t *below = odds->of[c].below;
        below[0] = 0;
        for (int s = 0; s < FIRST; s++)
            below[s + 1] = (int16_t)(below[s] + first_odds[c][s] * (STP_ODDS_ALL / 256));
        const int left = STP_ODDS_ALL - below[FIRST], others = STP_ODDS_SYMBOLS - FIRST;
        for (int s = 1; s < others; s++)
            below[FIRST + s] = (int16_t)(below[FIRST] + s * left / others);
    }
}

/* The different corners so far, the last one first. */
typedef struct recent {
    stp_corner *corners;
    uint32_t count;
} recent;

/* Puts a sample in front; its equal leaves its place. */
static void recent_take(recent *r, uint32_t ago, uint32_t sample, uint32_t patch)
{
    const uint32_t moved = ago > 0 ? ago - 1 : r->count++;
    memmove(r->corners + 1, r->corners, moved * sizeof *r->corners);
    r->corners[0] = (stp_corner){0, sample, patch};
}

static stp_status corners_create(const stp_chunk *block, stp_corners *out, recent *r,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = block->level_begin[0][block->patch_count];
    STP_TRY(stp_alloc(&r->corners, count, sizeof *r->corners, "corners", err));
    STP_TRY(stp_alloc(&out->of, count, sizeof *out->of, "corners", err));
done:
    return status;
}

void stp_corners_clear(stp_corners *corners)
{
    free(corners->of);
    *corners = (stp_corners){0};
}

bool stp_has_corners(const stp_chunk *block)
{
    unsigned flags = 0;
    for (uint32_t p = 0; p < block->patch_count; p++)
        flags |= block->patches[p].flags;
    return flags & STP_PATCH_TRIANGLES;
}

/* Counts the samples that are not told. */
static void count_recalled(const stp_chunk *block, stp_corners *corners)
{
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const uint8_t *counts = block->patches[p].counts;
        const stp_corner *of = corners->of + block->level_begin[0][p];
        for (unsigned j = 0; j < counts[1]; j++) {
            const unsigned end = stp_level_children_begin(j + 1, counts[1], counts[0]);
            for (unsigned k = stp_level_children_begin(j, counts[1], counts[0]); k < end; k++)
                corners->recalled[k + 1 == end] += of[k].ago > 0;
        }
    }
}

/* A coordinate on another patch's lattice. */
static uint32_t position_on(int32_t origin, uint16_t position, int shift)
{
    const int64_t at = (int64_t)origin + position;
    if (shift > 30 || shift < -30)
        return 0;
    return (uint32_t)(shift < 0 ? at >> -shift : at * (INT64_C(1) << shift));
}

stp_sample stp_corner_recall(const stp_chunk *block, stp_corner corner, const stp_patch *patch)
{
    const stp_patch *from = &block->patches[corner.patch];
    const int shift = from->exponent - patch->exponent;
    stp_sample out = block->samples[0][corner.sample];
    for (int i = 0; i < 3; i++)
        out.position[i] = (uint16_t)(position_on(from->origin[i], out.position[i], shift) -
                                     (uint32_t)patch->origin[i]);
    if (out.radius > 0)
        out.radius = (uint8_t)(out.radius + STP_RADIUS_CODES_PER_OCTAVE * shift);
    return out;
}

/* Finds the last equal of a sample among the corners so far. */
static stp_corner last_equal(const stp_chunk *block, const recent *r, uint32_t sample,
                             uint32_t patch)
{
    const stp_sample *own = &block->samples[0][sample];
    for (uint32_t i = 0; i < r->count; i++) {
        stp_corner found = r->corners[i];
        if (memcmp(block->samples[0][found.sample].normal, own->normal, sizeof own->normal) != 0)
            continue;
        const stp_sample equal = stp_corner_recall(block, found, &block->patches[patch]);
        found.ago = i + 1;
        if (memcmp(&equal, own, sizeof equal) == 0)
            return found;
    }
    return (stp_corner){0, sample, patch};
}

stp_status stp_corners_find(const stp_chunk *block, stp_corners *out, stp_error *err)
{
    stp_status status = STP_OK;
    recent r = {0};
    STP_TRY(corners_create(block, out, &r, err));
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const bool triangles = block->patches[p].flags & STP_PATCH_TRIANGLES;
        for (uint32_t i = block->level_begin[0][p]; i < block->level_begin[0][p + 1]; i++) {
            out->of[i] = triangles ? last_equal(block, &r, i, p) : (stp_corner){0, i, p};
            if (triangles)
                recent_take(&r, out->of[i].ago, i, p);
        }
    }
    count_recalled(block, out);
    if (out->recalled[0] + out->recalled[1] == 0)
        stp_corners_clear(out);
done:
    free(r.corners);
    return status;
}

stp_status stp_corners_put(const stp_chunk *block, const stp_corners *corners, unsigned lane,
                           stp_symbol_writer *w, stp_error *err)
{
    corner_odds odds = {0};
    odds_begin(&odds);
    const uint32_t count = block->level_begin[0][block->patch_count];
    const stp_status status = stp_symbols_reserve(w, (size_t)2 * count, err);
    for (uint32_t p = 0; status == STP_OK && p < block->patch_count; p++) {
        const uint32_t begin = block->level_begin[0][p];
        if (!(block->patches[p].flags & STP_PATCH_TRIANGLES))
            continue;
        for (uint32_t i = begin; i < block->level_begin[0][p + 1]; i++) {
            const uint32_t ago = corners->of[i].ago, far = ago > NEAR ? ago - NEAR : 0;
            const unsigned bits = far > 0 ? 31u - (unsigned)__builtin_clz(far) : 0;
            stp_symbol_put(w, lane, &odds.of[context_of(corners->of, begin, i)], SHIFT,
                           far > 0 ? NEAR + 1 + bits : ago, 0, 0);
            if (bits > 0)
                stp_symbol_put_bits(w, lane, far - (UINT32_C(1) << bits), bits);
        }
    }
    return status;
}

static uint32_t get_ago(stp_symbol_reader *r, unsigned lane, stp_odds *odds)
{
    uint32_t none;
    const unsigned symbol = stp_symbol_get(r, lane, odds, SHIFT, 0, &none);
    const unsigned bits = symbol - NEAR - 1;
    if (symbol <= NEAR)
        return symbol;
    return NEAR + (UINT32_C(1) << bits) + (bits > 0 ? stp_symbol_get_bits(r, lane, bits) : 0);
}

stp_status stp_corners_get(stp_symbol_reader *symbols, unsigned lane, const stp_chunk *block,
                           stp_corners *out, stp_error *err)
{
    stp_status status = STP_OK;
    corner_odds odds = {0};
    recent r = {0};
    odds_begin(&odds);
    STP_TRY(corners_create(block, out, &r, err));
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const uint32_t begin = block->level_begin[0][p];
        const bool triangles = block->patches[p].flags & STP_PATCH_TRIANGLES;
        for (uint32_t i = begin; i < block->level_begin[0][p + 1]; i++) {
            out->of[i] = (stp_corner){0, i, p};
            if (!triangles)
                continue;
            const uint32_t ago = get_ago(symbols, lane, &odds.of[context_of(out->of, begin, i)]);
            if (ago > r.count)
                STP_TRY(stp_error_set(err, STP_CORRUPT, "a corner that was never told"));
            if (ago > 0)
                out->of[i] = (stp_corner){ago, r.corners[ago - 1].sample, r.corners[ago - 1].patch};
            recent_take(&r, ago, i, p);
        }
    }
    count_recalled(block, out);
done:
    free(r.corners);
    return status;
}
