/* Decoded chunks in memory: one block for all arrays. */
#include "base/memory.h"
#include "formats/chunk/chunk_file.h"

#include <stdlib.h>
#include <string.h>

/* Counts are at most 2^16 patches and 2^16 samples a level, so no size overflows. */
static size_t arrays_bytes(uint32_t patch_count, const uint32_t sample_count[STP_LEVEL_COUNT],
                           int finest_level)
{
    size_t bytes = (size_t)patch_count * sizeof(stp_patch);
    bytes += STP_LEVEL_COUNT * ((size_t)patch_count + 1) * sizeof(uint32_t);
    for (int l = finest_level; l < STP_LEVEL_COUNT; l++)
        bytes += (size_t)sample_count[l] * sizeof(stp_sample);
    return bytes;
}

size_t stp_chunk_memory_bytes(const stp_chunk_entry *entry, int finest_level)
{
    return sizeof(stp_chunk) + arrays_bytes(entry->patch_count, entry->sample_count, finest_level);
}

/* All arrays need 4-byte alignment or less, and their sizes keep it. */
static void place_arrays(stp_chunk *chunk, const uint32_t sample_count[STP_LEVEL_COUNT])
{
    char *next = chunk->memory;
    chunk->patches = (stp_patch *)(void *)next;
    next += (size_t)chunk->patch_count * sizeof(stp_patch);
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        chunk->level_begin[l] = (uint32_t *)(void *)next;
        chunk->level_begin[l][chunk->patch_count] = sample_count[l];
        next += ((size_t)chunk->patch_count + 1) * sizeof(uint32_t);
    }
    for (int l = chunk->finest_level; l < STP_LEVEL_COUNT; l++) {
        chunk->samples[l] = (stp_sample *)(void *)next;
        next += (size_t)sample_count[l] * sizeof(stp_sample);
    }
}

stp_status stp_chunk_create_blank(stp_chunk **out, uint32_t patch_count,
                                  const uint32_t sample_count[STP_LEVEL_COUNT], int finest_level,
                                  stp_chunk_scratch *scratch, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    STP_TRY(stp_alloc(&chunk, 1, sizeof *chunk, "chunk", err));
    chunk->patch_count = patch_count;
    chunk->finest_level = finest_level;
    size_t bytes = arrays_bytes(patch_count, sample_count, finest_level);
    chunk->memory_capacity = bytes;
    if (scratch->spare_bytes >= bytes) {
        chunk->memory = scratch->spare;
        chunk->memory_capacity = scratch->spare_bytes;
        scratch->spare = NULL;
        scratch->spare_bytes = 0;
    } else {
        chunk->memory = malloc(bytes);
    }
    if (!chunk->memory) {
        status = stp_error_set(err, STP_OUT_OF_MEMORY,
                               "no memory for the samples of a chunk: %zu bytes", bytes);
        goto done;
    }
    chunk->memory_bytes = sizeof *chunk + bytes;
    place_arrays(chunk, sample_count);
    memset(chunk->patches, 0, patch_count * sizeof *chunk->patches); /* also the padding */
    *out = chunk;
    chunk = NULL;
done:
    stp_chunk_destroy(&chunk);
    return status;
}

stp_status stp_chunk_create(stp_chunk **out, uint32_t patch_count,
                            const uint32_t sample_count[STP_LEVEL_COUNT], int finest_level,
                            stp_error *err)
{
    stp_chunk_scratch none = {0};
    stp_status status =
        stp_chunk_create_blank(out, patch_count, sample_count, finest_level, &none, err);
    if (status != STP_OK)
        return status;
    memset((*out)->memory, 0, (*out)->memory_bytes - sizeof **out);
    place_arrays(*out, sample_count);
    return STP_OK;
}

void stp_chunk_box(const stp_chunk *chunk, stp_dvec3 origin, stp_dbox *box)
{
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++) {
            stp_dvec3 at = stp_sample_position(&chunk->samples[0][i], &chunk->patches[p]);
            stp_dbox_add(box, stp_dvec3_add(origin, at));
        }
}

void stp_chunk_destroy(stp_chunk **chunk)
{
    if (!*chunk)
        return;
    free((*chunk)->memory);
    free((*chunk)->block_ends);
    free((*chunk)->rasters);
    free((*chunk)->squares);
    free(*chunk);
    *chunk = NULL;
}

stp_status stp_chunk_scratch_reserve(stp_chunk_scratch *scratch, size_t bytes, stp_error *err)
{
    if (bytes <= scratch->bytes)
        return STP_OK;
    free(scratch->memory);
    scratch->bytes = 0;
    scratch->context = NULL;
    scratch->memory = malloc(bytes); /* not zeroed: it is written before it is read */
    if (!scratch->memory)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for %zu bytes to decode a chunk",
                             bytes);
    scratch->bytes = bytes;
    return STP_OK;
}

void stp_chunk_scratch_free(stp_chunk_scratch *scratch)
{
    free(scratch->memory);
    free(scratch->spare);
    *scratch = (stp_chunk_scratch){0};
}

void stp_chunk_recycle(stp_chunk **chunk, stp_chunk_scratch *scratch)
{
    if (*chunk && (*chunk)->memory_capacity > scratch->spare_bytes) {
        free(scratch->spare);
        scratch->spare = (*chunk)->memory;
        scratch->spare_bytes = (*chunk)->memory_capacity;
        (*chunk)->memory = NULL;
    }
    stp_chunk_destroy(chunk);
}
