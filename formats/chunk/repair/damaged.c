/* Opens a damaged chunk file: mends it, and finds how far each chunk can be read. */
#include "formats/chunk/repair/damaged.h"

#include "base/checked.h"
#include "base/file.h"
#include "base/memory.h"
#include "formats/chunk/codec/segment.h"
#include "formats/chunk/repair/lost_entries.h"
#include "formats/chunk/repair/lost_header.h"
#include "formats/chunk/repair/lost_sections.h"
#include "formats/chunk/repair/mend_bit.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Whether all segments of a chunk match their checksums as they are. */
static stp_status is_whole(const stp_damaged *d, const stp_chunk_entry *e, bool *whole,
                           stp_error *err)
{
    stp_status status = STP_OK;
    const size_t size = e->segment_end[STP_SEGMENT_COUNT - 1];
    uint8_t *bytes = NULL;
    uint32_t begin = 0;
    *whole = stp_range_inside(e->offset, size, d->file_bytes);
    STP_TRY(stp_alloc(&bytes, (*whole ? size : 0) + 1, 1, "payload", err));
    if (*whole)
        STP_TRY(stp_damaged_read(d, e->offset, bytes, size, err));
    for (int s = 0; s < STP_SEGMENT_COUNT && *whole; s++) {
        *whole = stp_hash(bytes + begin, e->segment_end[s] - begin) == e->segment_hash[s];
        begin = e->segment_end[s];
    }
done:
    free(bytes);
    return status;
}

/* Sets how far a chunk can be read: up to the first segment that is neither sound nor mended. */
static stp_status find_finest(stp_damaged *d, uint32_t id, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_entry *e = &d->entries[id];
    uint8_t *bytes = NULL;
    uint32_t begin = 0;
    bool lost[STP_SEGMENT_COUNT] = {false}, whole = false;
    STP_TRY(is_whole(d, e, &whole, err));
    d->finest[id] = whole ? 0 : STP_NOTHING_READABLE;
    if (whole)
        goto done;
    STP_TRY(stp_lost_blocks_mend(d, id, lost, err));
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        char what[64];
        bool sound = false;
        size_t size = e->segment_end[s] - begin;
        uint64_t at = e->offset + begin;
        snprintf(what, sizeof what, "segment %d of chunk %" PRIu32, s, id);
        if (!lost[s])
            STP_TRY(stp_damaged_read_checked(d, at, size, e->segment_hash[s], UINT64_MAX, what,
                                             &bytes, &sound, err));
        if (!sound) {
            stp_damaged_say(d, "%s (%zu bytes at byte %" PRIu64 ") is lost", what, size, at);
            goto done;
        }
        d->finest[id] = (uint8_t)(2 - s);
        begin = e->segment_end[s];
        free(bytes);
        bytes = NULL;
    }
done:
    free(bytes);
    return status;
}

/* ---- metadata and directory ---- */

static stp_status read_metadata(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_header *h = &d->header;
    size_t size = (size_t)h->metadata_bytes;
    uint8_t *bytes = NULL;
    bool sound = false;
    STP_TRY(stp_damaged_read_checked(d, h->metadata_offset, size, h->metadata_hash, UINT64_MAX,
                                     "the metadata", &bytes, &sound, err));
    d->metadata_lost = !sound;
    if (!sound)
        stp_damaged_say(d, "the metadata (%zu bytes at byte %" PRIu64 ") is lost", size,
                        h->metadata_offset);
done:
    d->metadata = (char *)bytes;
    return status;
}

/* Takes the entries of a page whose checksum matches. */
static stp_status take_page(stp_damaged *d, uint32_t page, const uint8_t *bytes, stp_error *err)
{
    stp_error inner = {0};
    for (uint32_t i = 0; i < stp_page_entry_count(&d->header, page); i++) {
        uint32_t id = page * STP_PAGE_ENTRIES + i;
        if (stp_entry_read(bytes + (size_t)i * d->header.entry_bytes, id, &d->header,
                           &d->entries[id], &inner) != STP_OK)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: cannot be repaired: its checksums are right, but it was "
                                 "written wrong: %s",
                                 d->path, inner.message);
        d->known[id] = true;
    }
    return STP_OK;
}

static stp_status read_page(stp_damaged *d, uint32_t page, bool *lost, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    uint64_t at = stp_page_offset(&d->header, page);
    size_t size = stp_page_bytes(&d->header, page), hashed = size - STP_HASH_BYTES;
    char what[64];
    STP_TRY(stp_alloc(&bytes, size, 1, "directory page", err));
    if (stp_range_inside(at, size, d->file_bytes))
        STP_TRY(stp_damaged_read(d, at, bytes, size, err));
    uint64_t hash = stp_get_u64(bytes + hashed);
    bool sound = stp_hash(bytes, hashed) == hash;
    snprintf(what, sizeof what, "directory page %" PRIu32, page);
    if (!sound)
        STP_TRY(stp_damaged_mend_bit(d, at, bytes, hashed, (stp_hash_place){hash, UINT64_MAX, true},
                                     what, &sound, err));
    if (sound) {
        STP_TRY(take_page(d, page, bytes, err));
    } else {
        stp_damaged_say(d, "%s (%zu bytes at byte %" PRIu64 ") is damaged", what, size, at);
        *lost = true;
    }
done:
    free(bytes);
    return status;
}

static stp_status read_directory(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t count = d->header.chunk_count;
    bool lost = false;
    STP_TRY(stp_alloc(&d->entries, count, sizeof *d->entries, "directory", err));
    STP_TRY(stp_alloc(&d->known, count, sizeof *d->known, "directory", err));
    STP_TRY(stp_alloc(&d->finest, count, sizeof *d->finest, "directory", err));
    memset(d->finest, STP_NOTHING_READABLE, count);
    for (uint32_t page = 0; page < stp_page_count(&d->header); page++)
        STP_TRY(read_page(d, page, &lost, err));
    for (uint32_t id = 0; id < count; id++)
        if (d->known[id])
            STP_TRY(find_finest(d, id, err));
    if (lost)
        STP_TRY(stp_lost_entries_find(d, err));
done:
    return status;
}

stp_status stp_damaged_open(stp_damaged *out, const char *path, const stp_repair_params *params,
                            stp_error *err)
{
    stp_status status = STP_OK;
    stp_damaged d = {.path = path, .params = params, .descriptor = -1};
    STP_TRY(stp_file_open(path, &d.descriptor, &d.file_bytes, err));
    STP_TRY(stp_lost_header_read(&d, err));
    STP_TRY(read_metadata(&d, err));
    STP_TRY(read_directory(&d, err));
    STP_TRY(stp_lost_sections_mend(&d, err));
    STP_TRY(stp_lost_header_finish(&d, err));
done:
    if (status != STP_OK)
        stp_damaged_close(&d);
    *out = d;
    return status;
}

void stp_damaged_close(stp_damaged *d)
{
    for (size_t i = 0; i < d->mend_count; i++)
        free(d->mends[i].bytes);
    free(d->mends);
    free(d->metadata);
    free(d->entries);
    free(d->known);
    free(d->finest);
    free(d->table);
    if (d->descriptor >= 0)
        close(d->descriptor);
    *d = (stp_damaged){.descriptor = -1};
}
