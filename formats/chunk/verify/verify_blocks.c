/* Checks the table of blocks against the payloads. */
#include "formats/chunk/verify/verify_blocks.h"

#include "base/memory.h"
#include "formats/chunk/layout.h"

#include <inttypes.h>
#include <stdlib.h>

stp_status stp_verify_block_table(const stp_chunk_file *file, const stp_chunk_entry *entries,
                                  stp_error *err)
{
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    uint64_t next = 0;
    if (info->header_damaged)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: one of the two copies of its header is damaged: repair the file",
                             stp_chunk_file_path(file));
    for (uint32_t id = 0; id < info->chunk_count; id++) {
        if (entries[id].block_count > 0 && entries[id].first_block != next)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: chunk %" PRIu32
                                 ": the records of its blocks do not follow those before them",
                                 stp_chunk_file_path(file), id);
        next += entries[id].block_count;
    }
    return next == info->block_count
               ? STP_OK
               : stp_error_set(err, STP_CORRUPT,
                               "%s: its table has %" PRIu64 " blocks, its chunks have %" PRIu64,
                               stp_chunk_file_path(file), info->block_count, next);
}

/* What a record says wrongly of its part of the chunk, or NULL. */
static const char *count_fault(const stp_block *block, const stp_chunk *chunk, uint32_t end)
{
    const uint32_t first = block->first_patch;
    if (first + block->patch_count != end)
        return "its record has other patches than its payload";
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        if (chunk->level_begin[l][end] - chunk->level_begin[l][first] != block->sample_count[l])
            return "its record has other counts than its payload";
    return NULL;
}

static stp_status check_hashes(stp_chunk_file *file, const stp_block *block, bool *sound,
                               stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *payload = NULL;
    size_t at = 0;
    *sound = true;
    STP_TRY(stp_alloc(&payload, (size_t)stp_block_payload_bytes(block, 0) + 1, 1, "a block", err));
    STP_TRY(stp_block_fetch(file, block, 0, stp_block_payload_bytes(block, 0), payload, err));
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        *sound = *sound && stp_hash(payload + at, block->parts[s].bytes) == block->parts[s].hash;
        at += block->parts[s].bytes;
    }
done:
    free(payload);
    return status;
}

stp_status stp_verify_blocks(stp_chunk_file *file, const stp_chunk *chunk,
                             const stp_chunk_entry *entry, stp_block **blocks, stp_error *err)
{
    stp_status status = STP_OK;
    stp_block *list = NULL;
    *blocks = NULL;
    if (entry->block_count == 0)
        return STP_OK;
    STP_TRY(stp_alloc(&list, entry->block_count, sizeof *list, "blocks", err));
    STP_TRY(stp_chunk_file_blocks(file, chunk->id, list, err));
    for (uint32_t b = 0; b < entry->block_count; b++) {
        bool sound = true;
        const char *fault = chunk->block_count == entry->block_count
                                ? count_fault(&list[b], chunk, chunk->block_ends[b])
                                : "its chunk has another number of blocks than the table";
        if (!fault)
            STP_TRY(check_hashes(file, &list[b], &sound, err));
        if (fault || !sound) {
            status = stp_error_set(err, STP_CORRUPT, "%s: chunk %" PRIu32 ": block %" PRIu32 ": %s",
                                   stp_chunk_file_path(file), chunk->id, b,
                                   fault ? fault : "its record has another checksum");
            goto done;
        }
    }
    *blocks = list;
    list = NULL;
done:
    free(list);
    return status;
}
