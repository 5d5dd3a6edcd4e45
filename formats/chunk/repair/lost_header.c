/* Reads, mends or rebuilds the header of a damaged chunk file. */
#include "formats/chunk/repair/lost_header.h"

#include "base/memory.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* ---- a header that its checksum proves ---- */

/* Takes a header that says itself how long the file is: the file may have been cut, or appended to.
 */
static stp_status take_header(stp_damaged *d, const uint8_t *bytes, uint32_t size, stp_error *err)
{
    stp_error inner = {0};
    stp_status status = stp_header_read(bytes, size, stp_get_u64(bytes + 144), &d->header, &inner);
    if (status != STP_OK)
        return stp_error_set(err, status, "%s: cannot be repaired: %s", d->path, inner.message);
    uint64_t should = d->header.file_bytes;
    if (d->file_bytes > should)
        stp_damaged_say(d, "byte %" PRIu64 ": %" PRIu64 " bytes were appended: left out", should,
                        d->file_bytes - should);
    if (d->file_bytes < should)
        stp_damaged_say(d, "byte %" PRIu64 ": the file was cut: %" PRIu64 " bytes are missing",
                        d->file_bytes, should - d->file_bytes);
    /* Every chunk has more bytes than this. If fewer are left, most of the file is gone. */
    if (d->file_bytes / 64 < d->header.chunk_count)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: cannot be repaired: of %" PRIu64 " bytes only %" PRIu64
                             " are left; copy it again",
                             d->path, should, d->file_bytes);
    return STP_OK;
}

static stp_status mend_header(stp_damaged *d, uint8_t *bytes, uint32_t size, bool *sound,
                              stp_error *err)
{
    size_t hashed = size - STP_HASH_BYTES;
    uint64_t hash = stp_get_u64(bytes + hashed);
    *sound = stp_hash(bytes, hashed) == hash;
    if (*sound)
        return STP_OK;
    return stp_damaged_mend_bit(d, 0, bytes, hashed, (stp_hash_place){hash, true}, "the header",
                                sound, err);
}

/* ---- a header that the directory tells ---- */

/* Finds the directory's last page: the bytes at the file's end that match the checksum there. The
 * pages before it are whole. False if no page with the root's entry is found. */
static stp_status find_directory(const stp_damaged *d, uint64_t *offset, uint32_t *count,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    const size_t full = STP_PAGE_ENTRIES * STP_ENTRY_BYTES + STP_HASH_BYTES;
    uint8_t *bytes = NULL;
    uint64_t end = d->file_bytes;
    bool found = true;
    *count = 0;
    STP_TRY(stp_alloc(&bytes, full, 1, "directory page", err));
    while (found && end >= STP_HEADER_BYTES + full / STP_PAGE_ENTRIES) {
        size_t size = end - STP_HEADER_BYTES < full ? (size_t)(end - STP_HEADER_BYTES) : full;
        uint32_t least = *count == 0 ? 1 : STP_PAGE_ENTRIES;
        STP_TRY(stp_damaged_read(d, end - size, bytes + full - size, size, err));
        found = false;
        for (uint32_t n = STP_PAGE_ENTRIES; n >= least && !found; n--) {
            size_t hashed = n * STP_ENTRY_BYTES;
            const uint8_t *begin = bytes + full - STP_HASH_BYTES - hashed;
            found = hashed + STP_HASH_BYTES <= size &&
                    stp_hash(begin, hashed) == stp_get_u64(begin + hashed);
            if (!found)
                continue;
            *count += n;
            end -= hashed + STP_HASH_BYTES;
            *offset = end;
            if (stp_get_u32(begin + 20) == STP_CHUNK_NONE)
                goto done;
        }
    }
    *count = 0;
done:
    free(bytes);
    return status;
}

/* Derives from the entries what they say of the file. */
static stp_status sum_entries(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    stp_header *h = &d->header;
    uint8_t entry[STP_ENTRY_BYTES];
    for (uint32_t id = 0; id < h->chunk_count; id++) {
        uint64_t at = stp_page_offset(h, id / STP_PAGE_ENTRIES) +
                      (uint64_t)(id % STP_PAGE_ENTRIES) * STP_ENTRY_BYTES;
        STP_TRY(stp_damaged_read(d, at, entry, sizeof entry, err));
        uint64_t begin = stp_get_u64(entry), end = begin + stp_get_u32(entry + 16);
        if (end >= begin && end <= h->directory_offset && end > h->metadata_offset)
            h->metadata_offset = end;
        h->depth = entry[77] + 1u > h->depth ? entry[77] + 1u : h->depth;
        if (id == 0)
            h->point_count = stp_get_u64(entry + 80);
    }
    h->metadata_bytes = h->directory_offset - h->metadata_offset;
    if (h->metadata_bytes > STP_METADATA_BYTES_LIMIT)
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: cannot be repaired: its header is lost, and its directory "
                               "contradicts itself; copy it again",
                               d->path);
done:
    return status;
}

static stp_status hash_metadata(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    size_t size = (size_t)d->header.metadata_bytes;
    STP_TRY(stp_alloc(&bytes, size + 1, 1, "metadata", err));
    STP_TRY(stp_damaged_read(d, d->header.metadata_offset, bytes, size, err));
    d->header.metadata_hash = stp_hash(bytes, size);
done:
    free(bytes);
    return status;
}

static stp_status rebuild(stp_damaged *d, bool has_magic, stp_error *err)
{
    stp_status status = STP_OK;
    stp_header *h = &d->header;
    uint32_t count = 0;
    *h = (stp_header){.version_major = STP_CHUNK_FILE_MAJOR,
                      .header_bytes = STP_HEADER_BYTES,
                      .page_entries = STP_PAGE_ENTRIES,
                      .entry_bytes = STP_ENTRY_BYTES,
                      .metadata_offset = STP_HEADER_BYTES,
                      .file_bytes = d->file_bytes};
    STP_TRY(find_directory(d, &h->directory_offset, &count, err));
    if (count == 0 && !has_magic)
        return stp_error_set(err, STP_FORMAT, "%s: not a stipple chunk file", d->path);
    if (count == 0)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: cannot be repaired: its header is damaged, and so is the "
                             "directory at its end; copy it again",
                             d->path);
    h->chunk_count = count;
    STP_TRY(sum_entries(d, err));
    STP_TRY(hash_metadata(d, err));
    d->header_rebuilt = true;
done:
    return status;
}

stp_status stp_lost_header_read(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    static const uint8_t magic[8] = "STIPPLE";
    uint8_t *bytes = NULL;
    uint32_t size = STP_HEADER_BYTES;
    bool sound = false;
    if (d->file_bytes < STP_HEADER_BYTES)
        return stp_error_set(err, STP_FORMAT,
                             "%s: not a stipple chunk file, or nothing is left of it: it has only "
                             "%" PRIu64 " bytes",
                             d->path, d->file_bytes);
    STP_TRY(stp_alloc(&bytes, STP_HEADER_BYTES_LIMIT, 1, "header", err));
    STP_TRY(stp_damaged_read(d, 0, bytes, STP_HEADER_BYTES, err));
    status = stp_header_peek(bytes, &size, err);
    if (status == STP_VERSION && stp_hash(bytes, STP_HEADER_BYTES - STP_HASH_BYTES) ==
                                     stp_get_u64(bytes + STP_HEADER_BYTES - STP_HASH_BYTES))
        goto done; /* newer, and sound */
    if (status != STP_OK || size > d->file_bytes)
        size = STP_HEADER_BYTES;
    STP_TRY(stp_damaged_read(d, 0, bytes, size, err));
    STP_TRY(mend_header(d, bytes, size, &sound, err));
    if (!sound && size != STP_HEADER_BYTES)
        STP_TRY(mend_header(d, bytes, size = STP_HEADER_BYTES, &sound, err));
    STP_TRY(sound ? take_header(d, bytes, size, err)
                  : rebuild(d, memcmp(bytes, magic, sizeof magic) == 0, err));
done:
    free(bytes);
    return status;
}

/* ---- what a rebuilt header says of the points ---- */

static uint32_t attributes_of(const stp_sample *s, const stp_sample *first)
{
    uint32_t out = 0;
    out |= memcmp(s->rgb, first->rgb, sizeof s->rgb) != 0 ? (uint32_t)STP_HAS_COLOUR : 0u;
    out |= s->intensity != 0 ? (uint32_t)STP_HAS_INTENSITY : 0u;
    out |= s->class_id != 0 ? (uint32_t)STP_HAS_CLASS : 0u;
    out |= s->flags & STP_SAMPLE_OUTLIER ? (uint32_t)STP_HAS_OUTLIERS : 0u;
    out |= s->flags & STP_SAMPLE_CLOSED ? (uint32_t)STP_HAS_CLOSED : 0u;
    out |= stp_sample_fit_of(s) != STP_FIT_NEAREST ? (uint32_t)STP_HAS_FITS : 0u;
    return out;
}

static uint32_t shapes_of(const stp_chunk *chunk)
{
    uint32_t out = 0;
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        out |= chunk->patches[p].flags & STP_PATCH_STRIP ? (uint32_t)STP_HAS_LINES : 0u;
        out |= chunk->patches[p].flags & STP_PATCH_TRIANGLES ? (uint32_t)STP_HAS_TRIANGLES : 0u;
    }
    return out;
}

/* Derives box and attributes from the points that can be read. */
static stp_status tell_points(stp_damaged *d, stp_dbox *box, uint32_t *attributes, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    stp_sample first;
    bool any = false;
    *box = stp_dbox_empty();
    *attributes = 0;
    for (uint32_t id = 0; id < d->header.chunk_count; id++) {
        if (!d->known[id] || d->finest[id] != 0 || d->entries[id].child_count > 0)
            continue;
        STP_TRY(stp_damaged_chunk(d, id, 0, &chunk, err));
        first = any ? first : chunk->samples[0][0];
        any = true;
        stp_chunk_box(chunk, d->entries[id].origin, box);
        for (uint32_t i = 0; i < chunk->level_begin[0][chunk->patch_count]; i++)
            *attributes |= attributes_of(&chunk->samples[0][i], &first);
        *attributes |= shapes_of(chunk);
        stp_chunk_destroy(&chunk);
    }
done:
    stp_chunk_destroy(&chunk);
    return status;
}

/* Takes lambda and orientation from the metadata; if that is lost, from the damaged header, if they
 * are possible. */
static void tell_metadata(const stp_damaged *d, const uint8_t *found, stp_header *h)
{
    cJSON *json = cJSON_Parse(d->metadata);
    const cJSON *lambda = cJSON_GetObjectItemCaseSensitive(json, "lambda");
    const cJSON *orientation = cJSON_GetObjectItemCaseSensitive(json, "orientation");
    uint64_t word = stp_get_u64(found + 80);
    memcpy(&h->lambda, &word, sizeof word);
    if (cJSON_IsNumber(lambda))
        h->lambda = lambda->valuedouble;
    if (!isfinite(h->lambda) || !(h->lambda > 0.0))
        h->lambda = 1.0;
    h->orientation = stp_get_u32(found + 76);
    for (uint32_t o = 0; cJSON_IsString(orientation) && o <= STP_ORIENTATION_MIXED; o++)
        if (strcmp(orientation->valuestring, stp_orientation_name((stp_orientation)o)) == 0)
            h->orientation = o;
    if (h->orientation > STP_ORIENTATION_MIXED)
        h->orientation = STP_ORIENTATION_UNKNOWN;
    cJSON_Delete(json);
}

/* Sets of STP_HAS_* bits, the empty set included. */
#define ATTRIBUTE_SETS (STP_HAS_ALL + 1u)

/* Tries all attributes and orientations. True if the checksum, or everything that it covers, is
 * that of the header found. */
static bool prove(stp_header *h, const uint8_t *found)
{
    const size_t hashed = STP_HEADER_BYTES - STP_HASH_BYTES;
    uint8_t bytes[STP_HEADER_BYTES];
    for (uint32_t i = 0; i < ATTRIBUTE_SETS * (STP_ORIENTATION_MIXED + 1u); i++) {
        stp_header tried = *h;
        tried.attributes = i % ATTRIBUTE_SETS;
        tried.version_minor = stp_chunk_file_minor(tried.attributes);
        tried.orientation = i / ATTRIBUTE_SETS;
        stp_header_write(&tried, bytes);
        if (memcmp(bytes + hashed, found + hashed, STP_HASH_BYTES) == 0 ||
            memcmp(bytes, found, hashed) == 0) {
            *h = tried;
            return true;
        }
    }
    return false;
}

stp_status stp_lost_header_finish(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    stp_header *h = &d->header;
    uint8_t found[STP_HEADER_BYTES], bytes[STP_HEADER_BYTES];
    if (!d->header_rebuilt)
        return STP_OK;
    STP_TRY(stp_damaged_read(d, 0, found, sizeof found, err));
    STP_TRY(tell_points(d, &h->box, &h->attributes, err));
    h->version_minor = stp_chunk_file_minor(h->attributes);
    if (stp_dbox_is_empty(&h->box)) /* no point can be read: as if there were one */
        h->box = (stp_dbox){{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    tell_metadata(d, found, h);
    bool proven = prove(h, found);
    d->header_told = !proven;
    stp_damaged_say(d, proven ? "the header is rebuilt; its checksum proves it"
                              : "the header is rebuilt; attributes and box are told from the "
                                "points, orientation and lambda from the metadata");
    stp_header_write(h, bytes);
    STP_TRY(stp_damaged_mend(d, 0, bytes, sizeof bytes, err));
done:
    return status;
}
