/* Checks header copies, sections, and the table of blocks against the payloads. */
#include "formats/chunk/verify/verify_blocks.h"

#include "base/memory.h"
#include "formats/chunk/chunk_reader.h"
#include "formats/chunk/layout.h"

#include <inttypes.h>
#include <stdlib.h>
#include <xxhash.h>

/* A section is read in parts of so many bytes. */
#define PART_BYTES ((size_t)1 << 20)

/* The checksum of a section, which may be larger than memory. */
static stp_status hash_section(const stp_chunk_file *file, const stp_section *section, bool again,
                               uint64_t *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    XXH3_state_t *state = XXH3_createState();
    if (!state || XXH3_64bits_reset(state) != XXH_OK) {
        status = stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for a checksum");
        goto done;
    }
    STP_TRY(stp_alloc(&bytes, PART_BYTES, 1, "a section", err));
    for (uint64_t at = 0; at < section->bytes; at += PART_BYTES) {
        const uint64_t left = section->bytes - at;
        const size_t size = left < PART_BYTES ? (size_t)left : PART_BYTES;
        STP_TRY(stp_chunk_file_bytes(file, section->offset + at, bytes, size, again, err));
        if (XXH3_64bits_update(state, bytes, size) != XXH_OK) {
            status = stp_error_set(err, STP_INTERNAL, "XXH3 failed");
            goto done;
        }
    }
    *out = XXH3_64bits_digest(state);
done:
    XXH3_freeState(state);
    free(bytes);
    return status;
}

static stp_status check_section(const stp_chunk_file *file, const stp_section *section,
                                stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t hash = 0;
    STP_TRY(hash_section(file, section, false, &hash, err));
    if (hash != section->hash && stp_chunk_file_may_mend(file, STP_CORRUPT))
        STP_TRY(hash_section(file, section, true, &hash, err));
    if (hash != section->hash)
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: the checksum of a section (%" PRIu64 " bytes at byte %" PRIu64
                               ") does not match: the file is damaged; copy it again",
                               file->path, section->bytes, section->offset);
done:
    return status;
}

/* Every record belongs to one chunk. */
static stp_status check_places(const stp_chunk_file *file, const stp_chunk_entry *entries,
                               stp_error *err)
{
    const stp_chunk_file_info *info = &file->info;
    uint64_t next = 0;
    for (uint32_t id = 0; id < info->chunk_count; id++) {
        if (entries[id].block_count > 0 && entries[id].first_block != next)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: chunk %" PRIu32
                                 ": the records of its blocks do not follow those before them",
                                 file->path, id);
        next += entries[id].block_count;
    }
    return next == info->block_count
               ? STP_OK
               : stp_error_set(err, STP_CORRUPT,
                               "%s: its table has %" PRIu64 " blocks, its chunks have %" PRIu64,
                               file->path, info->block_count, next);
}

stp_status stp_verify_sections(const stp_chunk_file *file, const stp_chunk_entry *entries,
                               stp_error *err)
{
    stp_status status = STP_OK;
    if (file->info.header_damaged)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: the copy of its header at byte %" PRIu32
                             " is damaged, or is not like the other: repair the file",
                             file->path, file->info.header_damaged_at);
    for (uint32_t i = 0; i < file->header.section_count; i++)
        STP_TRY(check_section(file, &file->header.sections[i], err));
    STP_TRY(check_places(file, entries, err));
done:
    return status;
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
        *sound = *sound &&
                 (uint32_t)stp_hash(payload + at, block->parts[s].bytes) == block->parts[s].hash;
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
