/* Mends sections: flipped bits by their checksums, records of blocks by their payloads. */
#include "formats/chunk/repair/lost_sections.h"

#include "base/memory.h"
#include "formats/chunk/block_table.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

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

/* Replaces records by those that the payload gives, if these are what the entry says. */
static stp_status replace_records(stp_damaged *d, uint32_t id, uint64_t at, bool *mended,
                                  stp_error *err)
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
    STP_TRY(stp_damaged_mend(d, at, records.data, records.size, err));
    stp_damaged_say(d, "the records of blocks of chunk %" PRIu32 " are made anew from its payload",
                    id);
done:
    free(records.data);
    return status;
}

static stp_status mend_records(stp_damaged *d, uint32_t id, uint64_t table, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_entry *e = &d->entries[id];
    const size_t size = (size_t)e->block_count * STP_BLOCK_BYTES;
    const uint64_t at = table + (uint64_t)e->first_block * STP_BLOCK_BYTES;
    uint8_t *bytes = NULL;
    char what[64];
    bool sound = false;
    snprintf(what, sizeof what, "the records of blocks of chunk %" PRIu32, id);
    STP_TRY(stp_damaged_read_checked(d, at, size, e->blocks_hash, what, &bytes, &sound, err));
    if (!sound)
        STP_TRY(replace_records(d, id, at, &sound, err));
    if (!sound) {
        d->sections_lost = true;
        stp_damaged_say(d, "%s (%zu bytes at byte %" PRIu64 ") are lost", what, size, at);
    }
done:
    free(bytes);
    return status;
}

/* Mends the table of blocks. If a chunk is lost, all records are written anew: then there is
 * nothing to mend. */
static stp_status mend_blocks(stp_damaged *d, uint64_t table, stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t id = 0; id < d->header.chunk_count; id++)
        if (!d->known[id] || d->finest[id] != 0)
            return STP_OK;
    for (uint32_t id = 0; id < d->header.chunk_count; id++)
        if (d->entries[id].block_count > 0)
            STP_TRY(mend_records(d, id, table, err));
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
                                     "a section", &bytes, &sound, err));
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
        STP_TRY(section->kind == STP_SECTION_BLOCKS ? mend_blocks(d, section->offset, err)
                                                    : mend_unknown(d, section, err));
    }
done:
    return status;
}
