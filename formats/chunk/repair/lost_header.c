/* Reads, mends or rebuilds the header of a damaged chunk file. */
#include "formats/chunk/repair/lost_header.h"

#include "base/memory.h"
#include "formats/chunk/repair/lost_places.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* ---- a header that its checksum proves ---- */

/* A copy of the header. Files of version 1 have one, at byte 0; files of version 2 a second one at
 * byte STP_HEADER_BYTES_2. */
typedef struct copy {
    uint64_t at;
    uint32_t size;
    uint8_t *bytes;
    bool hashed;       /* the checksum matches, maybe after a bit was put back */
    stp_status status; /* of reading it */
    stp_error fault;
    stp_header header;
} copy;

static stp_status read_copy(stp_damaged *d, uint64_t at, uint32_t size, copy *out, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t hashed = size - STP_HASH_BYTES;
    free(out->bytes);
    *out = (copy){.at = at, .size = size, .status = STP_CORRUPT};
    STP_TRY(stp_alloc(&out->bytes, size, 1, "header", err));
    STP_TRY(stp_damaged_read(d, at, out->bytes, size, err));
    const uint64_t hash = stp_get_u64(out->bytes + hashed);
    out->hashed = stp_hash(out->bytes, hashed) == hash;
    if (!out->hashed)
        STP_TRY(stp_damaged_mend_bit(d, at, out->bytes, hashed,
                                     (stp_hash_place){hash, UINT64_MAX, true}, "the header",
                                     &out->hashed, err));
    /* The header says how long the file is: the file may have been cut, or appended to. */
    if (out->hashed)
        out->status = stp_header_read(out->bytes, size, stp_get_u64(out->bytes + 144), &out->header,
                                      &out->fault);
done:
    return status;
}

/* Reads the copy at byte 0, whose size may be damaged. said: the size that it says, or 0. */
static stp_status read_first(stp_damaged *d, uint32_t said, copy *out, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t sizes[] = {said, STP_HEADER_BYTES, STP_HEADER_BYTES_2};
    for (int i = 0; i < 3 && !out->hashed; i++)
        if (sizes[i] > 0 && (i == 0 || sizes[i] != said))
            STP_TRY(read_copy(d, 0, sizes[i], out, err));
done:
    return status;
}

/* Takes the sound copy, of two the one of greater generation, and mends the other by it. False if
 * neither is sound. */
static stp_status take_copy(stp_damaged *d, const copy *first, const copy *second, bool *taken,
                            stp_error *err)
{
    const bool sound[2] = {first->status == STP_OK,
                           second->status == STP_OK && second->header.version_major >= 2};
    const bool newer = second->header.generation > first->header.generation;
    const copy *best = sound[1] && (!sound[0] || newer) ? second : first;
    const copy *other = best == first ? second : first;
    *taken = sound[0] || sound[1];
    if (!*taken)
        return STP_OK;
    d->header = best->header;
    if (sound[0] == sound[1] || best->header.version_major == 1)
        return STP_OK;
    stp_damaged_say(d,
                    "byte %" PRIu64 ": this copy of the header is damaged: taken from the copy at "
                    "byte %" PRIu64,
                    other->at, best->at);
    return stp_damaged_mend(d, other->at, best->bytes, best->size, err);
}

/* Says how the file's size differs from the header's. */
static stp_status check_size(stp_damaged *d, stp_error *err)
{
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

/* Derives from the entries what they say of the file. Where payloads begin tells the version. */
static stp_status sum_entries(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    stp_header *h = &d->header;
    uint8_t entry[STP_ENTRY_BYTES], root[STP_ENTRY_BYTES] = {0};
    uint64_t first = UINT64_MAX, block_count = 0;
    for (uint32_t id = 0; id < h->chunk_count; id++) {
        uint64_t at = stp_page_offset(h, id / STP_PAGE_ENTRIES) +
                      (uint64_t)(id % STP_PAGE_ENTRIES) * STP_ENTRY_BYTES;
        STP_TRY(stp_damaged_read(d, at, entry, sizeof entry, err));
        uint64_t begin = stp_get_u64(entry), end = begin + stp_get_u32(entry + 16);
        if (end >= begin && end <= h->directory_offset && end > h->metadata_offset)
            h->metadata_offset = end;
        first = begin < first ? begin : first;
        block_count += stp_get_u32(entry + 212);
        h->depth = entry[77] + 1u > h->depth ? entry[77] + 1u : h->depth;
        if (id > 0)
            continue;
        h->point_count = stp_get_u64(entry + 80);
        memcpy(root, entry, sizeof root);
    }
    if (first >= 2 * STP_HEADER_BYTES_2 && block_count <= h->directory_offset / STP_BLOCK_BYTES) {
        h->version_major = 2;
        h->header_bytes = STP_HEADER_BYTES_2;
        h->generation = 1;
        STP_TRY(stp_lost_places_find(d, block_count, root, err));
    }
    h->metadata_bytes = h->directory_offset - h->metadata_offset;
    if (h->metadata_offset > h->directory_offset || h->metadata_bytes > STP_METADATA_BYTES_LIMIT)
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: cannot be repaired: its header is lost, and its directory "
                               "contradicts itself; copy it again",
                               d->path);
done:
    return status;
}

static stp_status hash_range(const stp_damaged *d, uint64_t offset, uint64_t size, uint64_t *hash,
                             stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    STP_TRY(stp_alloc(&bytes, (size_t)size + 1, 1, "a part of the file", err));
    STP_TRY(stp_damaged_read(d, offset, bytes, (size_t)size, err));
    *hash = stp_hash(bytes, (size_t)size);
done:
    free(bytes);
    return status;
}

static stp_status rebuild(stp_damaged *d, bool has_magic, stp_error *err)
{
    stp_status status = STP_OK;
    stp_header *h = &d->header;
    uint32_t count = 0;
    *h = (stp_header){.version_major = 1,
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
    STP_TRY(hash_range(d, h->metadata_offset, h->metadata_bytes, &h->metadata_hash, err));
    d->header_rebuilt = true;
done:
    return status;
}

static bool has_magic(const copy *c)
{
    static const uint8_t magic[8] = "STIPPLE";
    return memcmp(c->bytes, magic, sizeof magic) == 0;
}

/* Takes a copy of the header, or rebuilds it. */
static stp_status take_or_rebuild(stp_damaged *d, const copy *first, const copy *second,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    bool taken = false;
    STP_TRY(take_copy(d, first, second, &taken, err));
    if (!taken && first->hashed)
        return stp_error_set(err, first->status, "%s: cannot be repaired: %s", d->path,
                             first->fault.message);
    STP_TRY(taken ? check_size(d, err) : rebuild(d, has_magic(first) || has_magic(second), err));
done:
    return status;
}

/* Whether a whole header of `size` bytes has a matching checksum. */
static stp_status is_hashed(const stp_damaged *d, uint32_t size, bool *out, stp_error *err)
{
    uint64_t hash = 0;
    uint8_t stored[STP_HASH_BYTES];
    stp_status status = STP_OK;
    STP_TRY(hash_range(d, 0, size - STP_HASH_BYTES, &hash, err));
    STP_TRY(stp_damaged_read(d, size - STP_HASH_BYTES, stored, sizeof stored, err));
    *out = stp_get_u64(stored) == hash;
done:
    return status;
}

stp_status stp_lost_header_read(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t bytes[STP_HEADER_BYTES];
    copy first = {.status = STP_CORRUPT}, second = {.status = STP_CORRUPT};
    uint32_t said = 0;
    bool newer = false;
    if (d->file_bytes < STP_HEADER_BYTES)
        return stp_error_set(err, STP_FORMAT,
                             "%s: not a stipple chunk file, or nothing is left of it: it has only "
                             "%" PRIu64 " bytes",
                             d->path, d->file_bytes);
    STP_TRY(stp_damaged_read(d, 0, bytes, sizeof bytes, err));
    stp_status peeked = stp_header_peek(bytes, &said, err);
    const uint32_t size = stp_get_u32(bytes + 12);
    if (peeked == STP_VERSION && size >= STP_HEADER_BYTES && size <= STP_HEADER_BYTES_LIMIT)
        STP_TRY(is_hashed(d, size, &newer, err));
    if (newer)
        return peeked;
    STP_TRY(read_first(d, said <= d->file_bytes ? said : 0, &first, err));
    if (first.status != STP_OK || first.header.version_major >= 2)
        STP_TRY(read_copy(d, STP_HEADER_BYTES_2, STP_HEADER_BYTES_2, &second, err));
    STP_TRY(take_or_rebuild(d, &first, &second, err));
done:
    free(first.bytes);
    free(second.bytes);
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

static uint16_t minor_of(const stp_header *h)
{
    if (h->version_major == 1)
        return stp_chunk_file_minor(h->attributes);
    return stp_header_section(h, STP_SECTION_FREE) ? STP_CHUNK_FILE_MINOR : 0;
}

/* Whether a header's checksum, or everything that it covers, is that of a copy found. */
static bool is_found(const stp_header *h, const uint8_t *found)
{
    const size_t hashed = h->header_bytes - STP_HASH_BYTES;
    uint8_t bytes[STP_HEADER_BYTES_2];
    bool out = false;
    stp_header_write(h, bytes);
    for (uint64_t at = 0; at < stp_header_span(h); at += h->header_bytes)
        out |= memcmp(bytes + hashed, found + at + hashed, STP_HASH_BYTES) == 0 ||
               memcmp(bytes, found + at, hashed) == 0;
    return out;
}

/* Tries all attributes and orientations. True if what was found proves one. */
static bool prove(stp_header *h, const uint8_t *found)
{
    for (uint32_t i = 0; i < ATTRIBUTE_SETS * (STP_ORIENTATION_MIXED + 1u); i++) {
        stp_header tried = *h;
        tried.attributes = i % ATTRIBUTE_SETS;
        tried.version_minor = minor_of(&tried);
        tried.orientation = i / ATTRIBUTE_SETS;
        if (is_found(&tried, found)) {
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
    uint8_t found[2 * STP_HEADER_BYTES_2], bytes[STP_HEADER_BYTES_2];
    if (!d->header_rebuilt)
        return STP_OK;
    STP_TRY(stp_damaged_read(d, 0, found, (size_t)stp_header_span(h), err));
    for (uint32_t i = 0; i < h->section_count; i++)
        STP_TRY(
            hash_range(d, h->sections[i].offset, h->sections[i].bytes, &h->sections[i].hash, err));
    STP_TRY(tell_points(d, &h->box, &h->attributes, err));
    h->version_minor = minor_of(h);
    if (stp_dbox_is_empty(&h->box)) /* no point can be read: as if there were one */
        h->box = (stp_dbox){{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    tell_metadata(d, found, h);
    bool proven = prove(h, found);
    d->header_told = !proven;
    stp_damaged_say(d, proven ? "the header is rebuilt; its checksum proves it"
                              : "the header is rebuilt; attributes and box are told from the "
                                "points, orientation and lambda from the metadata");
    stp_header_write(h, bytes);
    for (uint64_t at = 0; at < stp_header_span(h); at += h->header_bytes)
        STP_TRY(stp_damaged_mend(d, at, bytes, h->header_bytes, err));
done:
    return status;
}
