/* In which order the numbers of a chunk's attributes are stored. */
#include "formats/chunk/attribute/attribute_order.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

void stp_attribute_borrowers(const stp_patch *patch, const stp_sample *samples, int level,
                             uint8_t out[STP_PATCH_SAMPLES])
{
    const unsigned count = patch->counts[level];
    const unsigned parents = level + 1 < STP_LEVEL_COUNT ? patch->counts[level + 1] : 0;
    memset(out, STP_NOT_BORROWED, STP_PATCH_SAMPLES);
    for (unsigned j = 0; j < parents; j++) {
        const unsigned begin = stp_level_children_begin(j, parents, count);
        const unsigned end = stp_level_children_begin(j + 1, parents, count);
        if (begin < end)
            out[stp_attribute_borrowed(samples, begin, end)] = (uint8_t)j;
    }
}

unsigned stp_attribute_lender(const stp_patch *patch, const stp_sample *const *samples, int level,
                              unsigned i)
{
    for (int l = level; l > 0; l--) {
        const unsigned begin = stp_level_children_begin(i, patch->counts[l], patch->counts[l - 1]);
        const unsigned end =
            stp_level_children_begin(i + 1, patch->counts[l], patch->counts[l - 1]);
        i = stp_attribute_borrowed(samples[l - 1], begin, end);
    }
    return i;
}

/* The patch's samples of each level. */
static void samples_of(const stp_chunk *chunk, uint32_t p, const stp_sample *out[STP_LEVEL_COUNT])
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        out[l] = chunk->samples[l] + chunk->level_begin[l][p];
}

/* Adds the numbers that a level is the first to need. seen: by level-0 sample, borrowed before. */
static void add_level(stp_attribute_order *out, const stp_chunk *chunk, int level, bool *seen,
                      uint32_t *count)
{
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        const uint32_t first = chunk->level_begin[0][p];
        const stp_sample *samples[STP_LEVEL_COUNT];
        samples_of(chunk, p, samples);
        for (unsigned i = 0; i < patch->counts[level]; i++) {
            const uint32_t lender = first + stp_attribute_lender(patch, samples, level, i);
            if (level == STP_LEVEL_COUNT - 1)
                out->of_vertex[p] = lender;
            if (!seen[lender]) {
                out->holders[*count] = chunk->level_begin[level][p] + i;
                out->places[(*count)++] = lender;
            }
            seen[lender] = true;
        }
    }
    out->ends[STP_LEVEL_COUNT - 1 - level] = *count;
}

stp_status stp_attribute_order_make(stp_attribute_order *out, const stp_chunk *chunk,
                                    stp_error *err)
{
    stp_status status = STP_OK;
    bool *seen = NULL;
    uint32_t count = 0;
    const uint32_t samples = chunk->level_begin[0][chunk->patch_count];
    *out = (stp_attribute_order){0};
    STP_TRY(stp_alloc(&seen, samples, sizeof *seen, "attributes", err));
    STP_TRY(stp_alloc(&out->places, samples, sizeof *out->places, "attributes", err));
    STP_TRY(stp_alloc(&out->holders, samples, sizeof *out->holders, "attributes", err));
    STP_TRY(
        stp_alloc(&out->of_vertex, chunk->patch_count, sizeof *out->of_vertex, "attributes", err));
    for (int level = STP_LEVEL_COUNT - 1; level >= 0; level--)
        add_level(out, chunk, level, seen, &count);
done:
    free(seen);
    if (status != STP_OK)
        stp_attribute_order_clear(out);
    return status;
}

void stp_attribute_order_clear(stp_attribute_order *order)
{
    free(order->places);
    free(order->holders);
    free(order->of_vertex);
    *order = (stp_attribute_order){0};
}
