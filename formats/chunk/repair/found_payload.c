/* Decodes a leaf's payload without its directory entry. */
#include "formats/chunk/repair/found_payload.h"

#include "base/memory.h"
#include "formats/chunk/codec/segment.h"
#include "formats/chunk/codec/table/table_code.h"
#include "formats/chunk/codec/zstd/zstd_segment.h"
#include "formats/chunk/sample/patch.h"

#include <stdlib.h>

#define BLOCK_HEAD_BYTES 4u
/* No payload is longer: 4 levels of 64 k samples and as many patches, even if coding makes them
 * longer. */
#define PAYLOAD_BYTES_LIMIT ((uint64_t)16 << 20)

/* Bytes of a block, with its own size before it; 0 if they do not fit. */
static size_t block_bytes(const uint8_t *bytes, size_t left)
{
    if (left < BLOCK_HEAD_BYTES || stp_get_u32(bytes) > left - BLOCK_HEAD_BYTES)
        return 0;
    return BLOCK_HEAD_BYTES + (size_t)stp_get_u32(bytes);
}

/* Decodes the patches of codec 1 from their table. */
static stp_status table_patches(const uint8_t *bytes, size_t left, stp_patch *patches,
                                uint32_t patch_count, stp_error *err)
{
    stp_status status = STP_OK;
    size_t used = 0;
    stp_table table = {0};
    STP_TRY(stp_table_create(&table, STP_PATCH_COLUMN_COUNT, patch_count, err));
    STP_TRY(stp_table_decode(bytes, left, &table, &used, err));
    stp_patches_decode(patches, &table);
done:
    free(table.values);
    return status;
}

/* Decodes the patches of codec 2. *head: the bytes before level 2. */
static stp_status plane_patches(const uint8_t *bytes, size_t left, stp_patch *patches,
                                uint32_t patch_count, size_t *head, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_scratch scratch = {0};
    STP_TRY(
        stp_chunk_scratch_reserve(&scratch, stp_zstd_head_scratch_bytes(patch_count, false), err));
    STP_TRY(stp_zstd_patches_decode(bytes, left, patches, patch_count, false, &scratch, head, err));
done:
    stp_chunk_scratch_free(&scratch);
    return status;
}

/* Whether a chunk may have these counts. */
static bool may_have(const uint32_t counts[STP_LEVEL_COUNT], uint32_t patch_count)
{
    bool valid = true;
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        valid &= counts[l] >= patch_count && counts[l] <= STP_CHUNK_SAMPLES_LIMIT;
    return valid;
}

/* Counts samples by level from the patches; not valid if there are no patches. */
static stp_status count_samples(const uint8_t *bytes, size_t left, uint32_t patch_count,
                                stp_chunk_entry *entry, size_t *head, bool *valid, stp_error *err)
{
    stp_status status = STP_OK;
    stp_patch *patches = NULL;
    uint32_t *counts = entry->sample_count;
    STP_TRY(stp_alloc(&patches, patch_count, sizeof *patches, "patches", err));
    stp_status decoded = entry->codec == STP_CODEC_ZSTD
                             ? plane_patches(bytes, left, patches, patch_count, head, err)
                             : table_patches(bytes, left, patches, patch_count, err);
    *valid = decoded == STP_OK;
    if (decoded == STP_OUT_OF_MEMORY)
        status = decoded;
    if (decoded != STP_OK)
        goto done;
    for (uint32_t p = 0; p < patch_count; p++)
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            counts[l] += patches[p].counts[l];
    *valid = may_have(counts, patch_count);
done:
    free(patches);
    return status;
}

/* Finds where the segments of codec 1 end. Its blocks are patches and level 3, then for each finer
 * level the elder children, if there are any, and the last children. */
static bool find_ends(const uint8_t *bytes, size_t size, const uint32_t counts[STP_LEVEL_COUNT],
                      uint32_t ends[STP_SEGMENT_COUNT])
{
    size_t at = 0;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        int level = 2 - s;
        int blocks = (s == 0 ? 2 : 0) + (counts[level] > counts[level + 1] ? 2 : 1);
        for (int b = 0; b < blocks; b++) {
            size_t block = block_bytes(bytes + at, size - at);
            if (block == 0)
                return false;
            at += block;
        }
        ends[s] = (uint32_t)at;
    }
    return true;
}

/* Finds where the segments of codec 2 end: one level each, the first behind the patches. */
static bool find_plane_ends(const uint8_t *bytes, size_t size, size_t head,
                            const uint32_t counts[STP_LEVEL_COUNT],
                            uint32_t ends[STP_SEGMENT_COUNT])
{
    size_t at = head;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        size_t level = stp_zstd_level_bytes(bytes + at, size - at, counts[3 - s]);
        if (level == 0)
            return false;
        at += level;
        ends[s] = (uint32_t)at;
    }
    return true;
}

/* Finds where the segments end, and the counts, by the indices of blocks. */
static stp_status find_blocks(const uint8_t *bytes, size_t size, uint32_t patch_count,
                              stp_chunk_entry *entry, bool *valid, stp_error *err)
{
    stp_status status = STP_OK;
    stp_block_row *rows = NULL;
    uint32_t count = 0;
    size_t at = 0;
    *valid = false;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        size_t segment = stp_block_segment_bytes(bytes + at, size - at, s);
        if (segment == 0)
            return STP_OK;
        at += segment;
        entry->segment_end[s] = (uint32_t)at;
    }
    STP_TRY(stp_block_count_read(bytes, entry->segment_end[0], &count, err));
    STP_TRY(stp_alloc(&rows, count, sizeof *rows, "blocks", err));
    if (stp_block_rows_read(bytes, entry->segment_end[0], 0, rows, count, NULL) != STP_OK)
        goto done;
    for (uint32_t b = 0; b < count; b++)
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            entry->sample_count[l] += rows[b].sample_count[l];
    *valid = entry->sample_count[STP_LEVEL_COUNT - 1] == patch_count &&
             may_have(entry->sample_count, patch_count);
done:
    free(rows);
    return status;
}

/* Finds where the segments end, and the counts, by the patches. */
static stp_status find_segments(const uint8_t *bytes, size_t size, uint32_t patch_count,
                                stp_chunk_entry *entry, bool *valid, stp_error *err)
{
    stp_status status = STP_OK;
    size_t head = 0;
    STP_TRY(count_samples(bytes, size, patch_count, entry, &head, valid, err));
    if (*valid)
        *valid = entry->codec == STP_CODEC_ZSTD
                     ? find_plane_ends(bytes, size, head, entry->sample_count, entry->segment_end)
                     : find_ends(bytes, size, entry->sample_count, entry->segment_end);
done:
    return status;
}

static stp_status decode(const uint8_t *bytes, const stp_chunk_entry *e, stp_chunk **out,
                         stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    stp_chunk_scratch scratch = {0};
    uint32_t begin = 0;
    STP_TRY(stp_chunk_create(&chunk, e->patch_count, e->sample_count, 0, err));
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        STP_TRY(stp_segment_decode(bytes + begin, e->segment_end[s] - begin, s, e->codec, 0, chunk,
                                   &scratch, err));
        begin = e->segment_end[s];
    }
    *out = chunk;
    chunk = NULL;
done:
    stp_chunk_scratch_free(&scratch);
    stp_chunk_destroy(&chunk);
    return status == STP_OUT_OF_MEMORY ? status : STP_OK;
}

stp_status stp_found_payload(const stp_damaged *d, uint64_t end, uint32_t patch_count,
                             stp_chunk_entry *entry, stp_chunk **out, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    uint64_t left = end - entry->offset;
    size_t size = (size_t)(left < PAYLOAD_BYTES_LIMIT ? left : PAYLOAD_BYTES_LIMIT);
    bool valid = false;
    *out = NULL;
    if (patch_count == 0 || patch_count > STP_CHUNK_PATCHES_LIMIT)
        return STP_OK;
    STP_TRY(stp_alloc(&bytes, size, 1, "payload", err));
    STP_TRY(stp_damaged_read(d, entry->offset, bytes, size, err));
    STP_TRY(stp_codec_has_blocks((stp_codec)entry->codec)
                ? find_blocks(bytes, size, patch_count, entry, &valid, err)
                : find_segments(bytes, size, patch_count, entry, &valid, err));
    if (!valid)
        goto done;
    entry->patch_count = patch_count;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        uint32_t begin = s > 0 ? entry->segment_end[s - 1] : 0;
        entry->segment_hash[s] = stp_hash(bytes + begin, entry->segment_end[s] - begin);
    }
    STP_TRY(decode(bytes, entry, out, err));
done:
    free(bytes);
    return status;
}
