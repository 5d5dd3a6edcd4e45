/* Reads blocks, and what the file's table says of them. */
#include "formats/chunk/block/block.h"

#include "base/memory.h"
#include "formats/chunk/block/block_table.h"
#include "formats/chunk/block/packed_table.h"
#include "formats/chunk/chunk_fault.h"
#include "formats/chunk/chunk_reader.h"
#include "formats/chunk/codec/part.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* ---- the table ---- */

/* Reads the table of blocks as a whole. fresh: past all caches. */
static stp_status read_table(stp_chunk_file *file, bool fresh, uint8_t **out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_section *section = stp_header_blocks(&file->header);
    const size_t size = (size_t)section->bytes;
    uint8_t *bytes = NULL;
    stp_error inner = {0};
    STP_TRY(stp_alloc(&bytes, size + 1, 1, "the table of blocks", err));
    STP_TRY(stp_chunk_file_bytes(file, section->offset, bytes, size, fresh, err));
    if (section->kind != STP_SECTION_PACKED_BLOCKS) {
        *out = bytes;
        return STP_OK;
    }
    status = stp_table_unpack(bytes, size, stp_header_block_count(&file->header), out, &inner);
    if (status == STP_CORRUPT)
        stp_error_set(err, status, "%s: %s: the file is damaged; copy it again", file->path,
                      inner.message);
    else if (status != STP_OK)
        stp_error_set(err, status, "%s: %s", file->path, inner.message);
done:
    free(bytes);
    return status;
}

/* The table of blocks, read when a chunk's blocks are first asked for. */
static stp_status load_table(stp_chunk_file *file, uint8_t **out, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    pthread_mutex_lock(&file->mutex);
    *out = file->blocks;
    pthread_mutex_unlock(&file->mutex);
    if (*out)
        return STP_OK;
    status = read_table(file, false, &bytes, err);
    for (int i = 0; i < STP_FRESH_TRIES && stp_chunk_file_may_mend(file, status); i++)
        status = read_table(file, true, &bytes, err);
    STP_TRY(status);
    pthread_mutex_lock(&file->mutex);
    if (!file->blocks) {
        file->blocks = bytes;
        bytes = NULL;
    }
    *out = file->blocks;
    pthread_mutex_unlock(&file->mutex);
done:
    free(bytes);
    return status;
}

static stp_status check_records(const stp_chunk_file *file, const stp_chunk_entry *e, uint32_t id,
                                const uint8_t *records, stp_error *err)
{
    const size_t size = e->block_count * stp_record_bytes(stp_header_blocks(&file->header));
    return stp_hash(records, size) == e->blocks_hash
               ? STP_OK
               : stp_error_set(err, STP_CORRUPT,
                               "%s: chunk %" PRIu32 ": the checksum of its blocks' records does "
                               "not match: the file is damaged; copy it again",
                               file->path, id);
}

/* Reads a chunk's records from the file, past all caches, if those of the table are damaged. */
static stp_status find_records(stp_chunk_file *file, const stp_chunk_entry *e, uint32_t id,
                               const uint8_t **out, uint8_t **own, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *table = NULL;
    const stp_section *section = stp_header_blocks(&file->header);
    const size_t size = e->block_count * stp_record_bytes(section);
    const uint64_t at = (uint64_t)e->first_block * stp_record_bytes(section);
    STP_TRY(load_table(file, &table, err));
    *out = table + at;
    status = check_records(file, e, id, *out, err);
    if (section->kind == STP_SECTION_PACKED_BLOCKS) /* its checksum was right */
        return status;
    for (int i = 0; i < STP_FRESH_TRIES && stp_chunk_file_may_mend(file, status); i++) {
        if (!*own)
            STP_TRY(stp_alloc(own, size, 1, "records of blocks", err));
        STP_TRY(stp_chunk_file_bytes(file, section->offset + at, *own, size, true, err));
        *out = *own;
        status = check_records(file, e, id, *out, err);
    }
done:
    return status;
}

/* ---- the blocks of a chunk ---- */

stp_status stp_chunk_file_block_count(stp_chunk_file *file, uint32_t id, uint32_t *out,
                                      stp_error *err)
{
    stp_chunk_entry entry;
    stp_status status = stp_chunk_file_entry(file, id, &entry, err);
    if (status == STP_OK)
        *out = entry.block_count > 0 ? entry.block_count : 1;
    return status;
}

stp_status stp_chunk_file_blocks(stp_chunk_file *file, uint32_t id, stp_block *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_entry entry;
    const uint8_t *records = NULL;
    uint8_t *own = NULL;
    stp_error inner = {0};
    STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
    if (entry.block_count == 0) {
        *out = stp_block_of_entry(&entry, id);
        return STP_OK;
    }
    STP_TRY(find_records(file, &entry, id, &records, &own, err));
    status = stp_block_records_read(records, stp_record_bytes(stp_header_blocks(&file->header)),
                                    &entry, id, out, &inner);
    if (status != STP_OK)
        stp_error_set(err, status, "%s: %s", file->path, inner.message);
done:
    free(own);
    return status;
}

stp_status stp_chunk_file_records(stp_chunk_file *file, uint32_t id, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_entry entry;
    stp_block *blocks = NULL;
    STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
    STP_TRY(stp_alloc(&blocks, entry.block_count, sizeof *blocks, "blocks", err));
    STP_TRY(stp_chunk_file_blocks(file, id, blocks, err));
    STP_TRY(stp_block_records_write(blocks, &entry, out, err));
done:
    free(blocks);
    return status;
}

void stp_block_describe(const stp_block *block, stp_chunk_entry *entry)
{
    entry->box_min = block->box_min;
    entry->box_max = block->box_max;
    entry->cone_axis = block->cone_axis;
    entry->cone_angle = block->cone_angle;
    memcpy(entry->error, block->error, sizeof entry->error);
    memcpy(entry->tangential_error, block->tangential_error, sizeof entry->tangential_error);
    memcpy(entry->colour_error, block->colour_error, sizeof entry->colour_error);
}

const char *stp_block_fault(const stp_block *block, const stp_patch *patch)
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        if (stp_radius_decode(patch->radius[l], patch->exponent) > (double)block->radius_max)
            return "its radius exceeds its block's greatest";
    if (patch->flags & STP_PATCH_TWO_SIDED && !(block->flags & STP_PATCH_TWO_SIDED))
        return "it is two-sided and its block is not";
    if (block->flags & STP_CHUNK_CLOSED && !(patch->flags & STP_PATCH_CLOSED))
        return "its block is closed and it is not";
    return NULL;
}

/* ---- payloads ---- */

uint32_t stp_block_payload_bytes(const stp_block *block, int finest_level)
{
    uint32_t bytes = 0;
    for (int s = 0; s < stp_segment_count(finest_level); s++)
        bytes += block->parts[s].bytes;
    return bytes;
}

/* Reads a part again if a server sent other bytes than the file has. */
static stp_status mend_part(stp_chunk_file *file, const stp_block_part *part, uint8_t *bytes,
                            stp_error *err)
{
    stp_status status = STP_OK;
    for (int i = 0;
         i < STP_FRESH_TRIES && status == STP_OK && stp_byte_source_is_remote(file->source) &&
         (uint32_t)stp_hash(bytes, part->bytes) != part->hash;
         i++)
        status = stp_chunk_file_bytes(file, part->offset, bytes, part->bytes, true, err);
    return status;
}

/* Reads bytes [begin, end) of a payload from the file; parts that follow each other there are read
 * at once. */
static stp_status read_parts(const stp_chunk_file *file, const stp_block *block, uint64_t begin,
                             uint64_t end, uint8_t *out, stp_error *err)
{
    uint64_t at = 0, run = 0, run_offset = 0;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        const stp_block_part *part = &block->parts[s];
        const uint64_t from = begin > at ? begin : at;
        const uint64_t to = end < at + part->bytes ? end : at + part->bytes;
        const uint64_t offset = part->offset + (from - at);
        at += part->bytes;
        if (from >= to)
            continue;
        run_offset = run > 0 ? run_offset : offset;
        run += to - from;
        if (to < end && s + 1 < STP_SEGMENT_COUNT &&
            block->parts[s + 1].offset == part->offset + part->bytes)
            continue;
        stp_status status =
            stp_chunk_file_bytes(file, run_offset, out + (to - run - begin), run, false, err);
        if (status != STP_OK)
            return status;
        run = 0;
    }
    return STP_OK;
}

stp_status stp_block_fetch(stp_chunk_file *file, const stp_block *block, uint32_t begin,
                           uint32_t end, uint8_t *out, stp_error *err)
{
    uint64_t at = 0;
    if (begin > end || end > stp_block_payload_bytes(block, 0))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "a block of chunk %" PRIu32 ": bytes %" PRIu32 " to %" PRIu32
                             " are not its own",
                             block->chunk, begin, end);
    stp_status status = read_parts(file, block, begin, end, out, err);
    for (int s = 0; s < STP_SEGMENT_COUNT && status == STP_OK; s++) {
        const uint32_t bytes = block->parts[s].bytes;
        if (at >= begin && at + bytes <= end)
            status = mend_part(file, &block->parts[s], out + (at - begin), err);
        at += bytes;
    }
    return status;
}

static stp_status decode_parts(const stp_chunk_file *file, const stp_block *block,
                               const stp_chunk_entry *entry, const uint8_t *payload,
                               stp_chunk *chunk, stp_chunk_scratch *scratch, stp_error *err)
{
    const int codec = (int)stp_codec_of_part((stp_codec)entry->codec);
    for (int s = 0; s < stp_segment_count(chunk->finest_level); s++) {
        const stp_block_part *part = &block->parts[s];
        stp_error inner = {0};
        if ((uint32_t)stp_hash(payload, part->bytes) != part->hash)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: chunk %" PRIu32 ": the checksum of a block (%" PRIu32
                                 " bytes at byte %" PRIu64
                                 ") does not match: the file is damaged; copy it again",
                                 file->path, block->chunk, part->bytes, part->offset);
        stp_status status = stp_part_decode(payload, part->bytes, s, codec, entry->child_count,
                                            chunk, scratch, &inner);
        if (status != STP_OK)
            return stp_error_set(
                err, status, "%s: chunk %" PRIu32 ": a block of segment %d at byte %" PRIu64 ": %s",
                file->path, block->chunk, s, part->offset, inner.message);
        payload += part->bytes;
    }
    return STP_OK;
}

stp_status stp_block_decode(stp_chunk_file *file, const stp_block *block, int finest_level,
                            const uint8_t *payload, stp_chunk_scratch *scratch, stp_chunk **out,
                            stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_entry entry;
    stp_chunk *chunk = NULL;
    stp_chunk_scratch own = {0};
    if (finest_level < 0 || finest_level > 2)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "level %d asked for: use 0, 1 or 2",
                             finest_level);
    STP_TRY(stp_chunk_file_entry(file, block->chunk, &entry, err));
    if (entry.block_count == 0)
        return stp_chunk_file_decode(file, block->chunk, finest_level, payload, scratch, out, err);
    scratch = scratch ? scratch : &own;
    STP_TRY(stp_chunk_create_blank(&chunk, block->patch_count, block->sample_count, finest_level,
                                   scratch, err));
    chunk->id = block->chunk;
    chunk->is_block = true;
    chunk->linked = (entry.flags & STP_CHUNK_LINKED) != 0;
    STP_TRY(decode_parts(file, block, &entry, payload, chunk, scratch, err));
    STP_TRY(stp_chunk_file_check(file, &entry, chunk, err));
    *out = chunk;
    chunk = NULL;
done:
    stp_chunk_scratch_free(&own);
    stp_chunk_destroy(&chunk);
    return status;
}

size_t stp_block_memory_bytes(const stp_block *block, int finest_level)
{
    const stp_chunk_entry entry = {.patch_count = block->patch_count,
                                   .sample_count = {block->sample_count[0], block->sample_count[1],
                                                    block->sample_count[2],
                                                    block->sample_count[3]}};
    return stp_chunk_memory_bytes(&entry, finest_level);
}
