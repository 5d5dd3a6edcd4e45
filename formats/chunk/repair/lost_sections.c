/* Mends sections: flipped bits by their checksums, records of blocks by their payloads. */
#include "formats/chunk/repair/lost_sections.h"

#include "base/checked.h"
#include "base/memory.h"
#include "formats/chunk/block/block_table.h"
#include "formats/chunk/block/packed_table.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Makes the records of a chunk's blocks from its payload. */
static stp_status make_records(const stp_damaged *d, const stp_chunk_entry *e, stp_bytes *records,
                               uint32_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *payload = NULL;
    const size_t size = e->segment_end[STP_SEGMENT_COUNT - 1];
    STP_TRY(stp_alloc(&payload, size + 1, 1, "payload", err));
    STP_TRY(stp_damaged_read(d, e->offset, payload, size, err));
    STP_TRY(stp_block_records_make(payload, e, records, count, err));
done:
    free(payload);
    return status;
}

stp_status stp_lost_blocks_describe(const stp_damaged *d, stp_chunk_entry *entry, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes records = {0};
    if (!stp_codec_has_blocks((stp_codec)entry->codec))
        return STP_OK;
    STP_TRY(make_records(d, entry, &records, &entry->block_count, err));
    entry->blocks_hash = stp_hash(records.data, records.size);
done:
    free(records.data);
    return status;
}

static bool is_packed(const stp_damaged *d)
{
    return stp_header_blocks(&d->header)->kind == STP_SECTION_PACKED_BLOCKS;
}

/* Unpacks the table of blocks, if that was not done. d->table stays NULL if it is lost. */
static stp_status unpack_table(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_section *section = stp_header_blocks(&d->header);
    const size_t size = (size_t)section->bytes;
    uint8_t *bytes = NULL;
    bool sound = true;
    if (d->table)
        return STP_OK;
    if (d->header_rebuilt) { /* the section's checksum is lost, the table has one of its own */
        STP_TRY(stp_alloc(&bytes, size + 1, 1, "the table of blocks", err));
        STP_TRY(stp_damaged_read(d, section->offset, bytes, size, err));
    } else {
        STP_TRY(stp_damaged_read_checked(d, section->offset, size, section->hash, UINT64_MAX,
                                         "the table of blocks", &bytes, &sound, err));
    }
    if (sound)
        status = stp_table_unpack(bytes, size, stp_header_block_count(&d->header), &d->table, err);
    if (status == STP_CORRUPT)
        status = STP_OK;
done:
    free(bytes);
    return status;
}

/* Where the records of a chunk's blocks are. An entry with blocks was checked against the table. */
static uint64_t records_at(const stp_damaged *d, uint32_t id)
{
    const stp_section *blocks = stp_header_blocks(&d->header);
    const uint64_t before = is_packed(d) ? 0 : d->entries[id].first_block;
    return blocks->offset + before * stp_record_bytes(blocks);
}

/* Replaces records by those that the payload gives, if these are what the entry says, as wide
 * records are not. */
static stp_status replace_records(stp_damaged *d, uint32_t id, bool *mended, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_entry *e = &d->entries[id];
    stp_bytes records = {0};
    uint32_t count = 0;
    stp_status made = make_records(d, e, &records, &count, err);
    if (made == STP_IO || made == STP_OUT_OF_MEMORY)
        STP_TRY(made);
    *mended = made == STP_OK && count == e->block_count &&
              stp_hash(records.data, records.size) == e->blocks_hash;
    if (!*mended)
        goto done;
    STP_TRY(stp_damaged_mend(d, records_at(d, id), records.data, records.size, err));
    stp_damaged_say(d, "the records of blocks of chunk %" PRIu32 " are made anew from its payload",
                    id);
done:
    free(records.data);
    return status;
}

/* Copies the records of a chunk's blocks from the unpacked table. */
static stp_status copy_records(stp_damaged *d, const stp_chunk_entry *e, uint8_t **records,
                               bool *sound, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t size = (size_t)e->block_count * STP_BLOCK_BYTES;
    *sound = false;
    STP_TRY(unpack_table(d, err));
    STP_TRY(stp_alloc(records, size + 1, 1, "records of blocks", err));
    if (d->table)
        memcpy(*records, d->table + (size_t)e->first_block * STP_BLOCK_BYTES, size);
    *sound = d->table && stp_hash(*records, size) == e->blocks_hash;
done:
    return status;
}

/* Reads the records of a chunk's blocks, and puts a flipped bit back. */
static stp_status read_records(stp_damaged *d, uint32_t id, uint8_t **records, bool *sound,
                               stp_error *err)
{
    const stp_chunk_entry *e = &d->entries[id];
    if (is_packed(d))
        return copy_records(d, e, records, sound, err);
    char what[64];
    snprintf(what, sizeof what, "the records of blocks of chunk %" PRIu32, id);
    return stp_damaged_read_checked(
        d, records_at(d, id), e->block_count * stp_record_bytes(stp_header_blocks(&d->header)),
        e->blocks_hash, UINT64_MAX, what, records, sound, err);
}

static stp_status mend_part(stp_damaged *d, const stp_block *block, uint32_t number, int segment,
                            bool *lost, stp_error *err)
{
    const stp_block_part *part = &block->parts[segment];
    uint8_t *bytes = NULL;
    char what[80];
    bool sound = false;
    snprintf(what, sizeof what, "block %" PRIu32 " of segment %d of chunk %" PRIu32, number,
             segment, block->chunk);
    stp_status status = stp_damaged_read_checked(d, part->offset, part->bytes, part->hash,
                                                 UINT32_MAX, what, &bytes, &sound, err);
    if (status == STP_OK && !sound)
        stp_damaged_say(d, "%s is lost", what);
    *lost |= !sound;
    free(bytes);
    return status;
}

stp_status stp_lost_blocks_mend(stp_damaged *d, uint32_t id, bool lost[STP_SEGMENT_COUNT],
                                stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_entry *e = &d->entries[id];
    uint8_t *records = NULL;
    stp_block *blocks = NULL;
    bool sound = false;
    if (e->block_count == 0)
        return STP_OK;
    STP_TRY(read_records(d, id, &records, &sound, err));
    STP_TRY(stp_alloc(&blocks, e->block_count, sizeof *blocks, "blocks", err));
    if (!sound || stp_block_records_read(records, stp_record_bytes(stp_header_blocks(&d->header)),
                                         e, id, blocks, NULL) != STP_OK)
        goto done;
    for (uint32_t b = 0; b < e->block_count; b++)
        for (int s = 0; s < STP_SEGMENT_COUNT; s++)
            STP_TRY(mend_part(d, &blocks[b], b, s, &lost[s], err));
done:
    free(records);
    free(blocks);
    return status;
}

static stp_status mend_records(stp_damaged *d, uint32_t id, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_entry *e = &d->entries[id];
    uint8_t *records = NULL;
    bool sound = false;
    /* A rebuilt entry may say that its records lie elsewhere. */
    const bool inside =
        stp_range_inside(e->first_block, e->block_count, stp_header_block_count(&d->header));
    if (inside)
        STP_TRY(read_records(d, id, &records, &sound, err));
    if (inside && !sound && !is_packed(d))
        STP_TRY(replace_records(d, id, &sound, err));
    if (!sound) {
        d->sections_lost = true;
        stp_damaged_say(d,
                        "the records of blocks of chunk %" PRIu32 " (at byte %" PRIu64 ") are lost",
                        id, records_at(d, id));
    }
done:
    free(records);
    return status;
}

/* Makes a packed table that is lost anew from all payloads, if these give the very bytes that were
 * written: another release of zstd may give others. If the section's checksum is lost, too, as many
 * bytes are enough: their records are checked chunk by chunk. */
static stp_status remake_table(stp_damaged *d, bool *mended, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_section *section = stp_header_blocks(&d->header);
    const uint64_t total = stp_header_block_count(&d->header);
    stp_bytes records = {0}, packed = {0}, own = {0};
    if (total * STP_BLOCK_BYTES / STP_PACKED_RATIO_MOST > section->bytes)
        return STP_OK; /* no table of so many records is so small */
    STP_TRY(stp_bytes_append(&records, NULL, (size_t)total * STP_BLOCK_BYTES, err));
    for (uint32_t id = 0; id < d->header.chunk_count; id++) {
        const stp_chunk_entry *e = &d->entries[id];
        uint32_t count = 0;
        own.size = 0;
        if (e->block_count == 0 || !stp_range_inside(e->first_block, e->block_count, total))
            continue;
        const stp_status made = make_records(d, e, &own, &count, err);
        if (made == STP_IO || made == STP_OUT_OF_MEMORY)
            STP_TRY(made);
        if (made == STP_OK && count == e->block_count)
            memcpy(records.data + (size_t)e->first_block * STP_BLOCK_BYTES, own.data, own.size);
    }
    STP_TRY(stp_table_pack(records.data, (size_t)total, &packed, err));
    *mended = packed.size > 0 && packed.size == section->bytes &&
              (d->header_rebuilt || stp_hash(packed.data, packed.size) == section->hash);
    if (*mended)
        STP_TRY(stp_damaged_mend(d, section->offset, packed.data, packed.size, err));
done:
    free(records.data);
    free(packed.data);
    free(own.data);
    return status;
}

/* Mends a packed table. */
static stp_status mend_packed(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    bool mended = false;
    STP_TRY(unpack_table(d, err));
    if (d->table)
        return STP_OK;
    STP_TRY(remake_table(d, &mended, err));
    d->sections_lost |= !mended;
    stp_damaged_say(d, "the table of blocks (at byte %" PRIu64 ") is %s",
                    stp_header_blocks(&d->header)->offset,
                    mended ? "made anew from the payloads" : "lost: it is written anew");
done:
    return status;
}

/* Mends the table of blocks. If a chunk is lost, all records are written anew: then there is
 * nothing to mend. */
static stp_status mend_table(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t id = 0; id < d->header.chunk_count; id++)
        if (!d->known[id] || d->finest[id] != 0)
            return STP_OK;
    if (is_packed(d))
        STP_TRY(mend_packed(d, err));
    if (d->sections_lost)
        return STP_OK;
    for (uint32_t id = 0; id < d->header.chunk_count; id++)
        if (d->entries[id].block_count > 0)
            STP_TRY(mend_records(d, id, err));
done:
    return status;
}

/* Mends a section that this program does not know. */
static stp_status mend_unknown(stp_damaged *d, const stp_section *section, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    bool sound = false;
    STP_TRY(stp_damaged_read_checked(d, section->offset, (size_t)section->bytes, section->hash,
                                     UINT64_MAX, "a section", &bytes, &sound, err));
    if (!sound) {
        d->sections_lost = true;
        stp_damaged_say(d, "a section (%" PRIu64 " bytes at byte %" PRIu64 ") is lost",
                        section->bytes, section->offset);
    }
done:
    free(bytes);
    return status;
}

stp_status stp_lost_sections_mend(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t i = 0; i < d->header.section_count; i++) {
        const stp_section *section = &d->header.sections[i];
        if (section == stp_header_blocks(&d->header))
            STP_TRY(mend_table(d, err));
        else if (!d->header_rebuilt) /* else its checksum is lost with the header */
            STP_TRY(mend_unknown(d, section, err));
    }
done:
    return status;
}
