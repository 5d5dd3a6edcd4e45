/* Encodes a chunk as payload bytes, and fills its directory entry. */
#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/segment.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/describe.h"
#include "formats/chunk/sample/patch.h"

#include <inttypes.h>
#include <stdlib.h>

static stp_status check_chunk(const stp_chunk *chunk, uint32_t counts[STP_LEVEL_COUNT],
                              stp_error *err)
{
    if (chunk->patch_count == 0 || chunk->patch_count > STP_CHUNK_PATCHES_LIMIT)
        return stp_error_set(err, STP_LIMIT, "a chunk of %" PRIu32 " patches: use 1 to %u",
                             chunk->patch_count, STP_CHUNK_PATCHES_LIMIT);
    if (chunk->finest_level != 0)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "a chunk without level 0 to be written");
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        counts[l] = chunk->level_begin[l][chunk->patch_count];
        if (counts[l] > STP_CHUNK_SAMPLES_LIMIT)
            return stp_error_set(err, STP_LIMIT,
                                 "a chunk of %" PRIu32 " samples at level %d: use at most %u",
                                 counts[l], l, STP_CHUNK_SAMPLES_LIMIT);
        for (uint32_t i = 0; i < chunk->patch_count; i++)
            if (chunk->level_begin[l][i + 1] - chunk->level_begin[l][i] !=
                chunk->patches[i].counts[l])
                return stp_error_set(err, STP_INVALID_ARGUMENT,
                                     "level_begin of patch %" PRIu32 ", level %d, contradicts its "
                                     "count",
                                     i, l);
    }
    stp_error inner = {0};
    if (stp_patches_check(chunk->patches, chunk->patch_count, counts, STP_CHUNK_CHILDREN_LIMIT,
                          &inner) != STP_OK ||
        stp_patches_check_kinds(chunk, &inner) != STP_OK)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "a chunk cannot be written: %s",
                             inner.message);
    return STP_OK;
}

/* ---- what the directory says ---- */

/* Least and greatest radius of all samples of all levels. */
static void find_radii(stp_chunk_entry *entry, const stp_chunk *chunk)
{
    entry->radius_min = INFINITY;
    entry->radius_max = 0.0f;
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        for (uint32_t i = 0; i < chunk->patch_count; i++) {
            uint8_t least = 255;
            uint8_t most = 0;
            for (uint32_t k = chunk->level_begin[l][i]; k < chunk->level_begin[l][i + 1]; k++) {
                uint8_t code = chunk->samples[l][k].radius;
                least = code < least ? code : least;
                most = code > most ? code : most;
            }
            int exponent = chunk->patches[i].exponent;
            float low = stp_round_down(stp_radius_decode(least, exponent));
            float high = stp_round_up(stp_radius_decode(most, exponent));
            entry->radius_min = fminf(entry->radius_min, low);
            entry->radius_max = fmaxf(entry->radius_max, high);
        }
    }
}

static void describe(stp_chunk_entry *entry, const stp_chunk *chunk)
{
    stp_patches_describe(chunk->patches, chunk->patch_count, entry);
    entry->flags |= chunk->linked ? STP_CHUNK_LINKED : 0;
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        entry->sample_count[l] = chunk->level_begin[l][chunk->patch_count];
    find_radii(entry, chunk);
}

stp_status stp_chunk_encode(const stp_chunk *chunk, stp_codec codec, void **payload,
                            stp_chunk_entry *entry, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes bytes = {0};
    stp_chunk_entry described = *entry;
    uint32_t counts[STP_LEVEL_COUNT];
    STP_TRY(check_chunk(chunk, counts, err));
    STP_TRY(stp_segments_encode(chunk, codec, &described, &bytes, err));
    describe(&described, chunk);
    *entry = described;
    *payload = bytes.data;
    bytes.data = NULL;
done:
    free(bytes.data);
    return status;
}
