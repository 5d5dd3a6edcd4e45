/* The chunk file's reader: header, directory pages when they are needed, payload segments.
 *
 * If bytes from a server fail their checksum, the reader asks for them again, up to STP_FRESH_TRIES
 * times and past all caches: bits may have flipped on the way, or in a cache. */
#include "formats/chunk/chunk_reader.h"
#include "base/checked.h"
#include "base/memory.h"
#include "formats/chunk/chunk_fault.h"
#include "formats/chunk/codec/segment.h"
#include "formats/chunk/metadata_check.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One request to a server also brings this many bytes of the directory pages that follow. */
#define PAGES_AHEAD_BYTES (512u << 10)

typedef struct stp_directory_page {
    stp_chunk_entry entries[STP_PAGE_ENTRIES];
} page;

const char *stp_orientation_name(stp_orientation orientation)
{
    static const char *const names[] = {"unknown", "file", "position", "propagated", "mixed"};
    return names[orientation];
}

/* Puts "PATH: " before the message. */
static stp_status locate(const stp_chunk_file *file, stp_status status, const stp_error *inner,
                         stp_error *err)
{
    return stp_error_set(err, status, "%s: %s", file->path, inner->message);
}

stp_status stp_chunk_file_bytes(const stp_chunk_file *file, uint64_t offset, void *data,
                                size_t size, bool again, stp_error *err)
{
    return again ? stp_byte_source_reread(file->source, offset, data, size, err)
                 : stp_byte_source_read(file->source, offset, data, size, err);
}

/* Whether reading again may help after this status. */
bool stp_chunk_file_may_mend(const stp_chunk_file *file, stp_status status)
{
    return status == STP_CORRUPT && stp_byte_source_is_remote(file->source);
}

/* ---- opening ---- */

/* Reads the copy of the header at `bytes`, of which `have` bytes are there; a longer header is read
 * from the file. */
static stp_status take_header(const stp_chunk_file *file, const uint8_t *bytes, size_t have,
                              bool again, stp_header *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t file_bytes = stp_byte_source_size(file->source);
    uint8_t *grown = NULL;
    uint32_t header_bytes = 0;
    status = stp_header_peek(bytes, &header_bytes, err);
    if (status != STP_FORMAT && (file_bytes < STP_HEADER_BYTES || header_bytes > file_bytes))
        return stp_error_set(err, STP_CORRUPT,
                             "it has only %" PRIu64
                             " bytes, less than its header: the file was cut; copy it again",
                             file_bytes);
    STP_TRY(status);
    if (header_bytes > have) {
        STP_TRY(stp_alloc(&grown, header_bytes, 1, "header", err));
        STP_TRY(stp_chunk_file_bytes(file, 0, grown, header_bytes, again, err));
        bytes = grown;
    }
    STP_TRY(stp_header_read(bytes, header_bytes, file_bytes, out, err));
done:
    free(grown);
    return status;
}

/* A file of version 2 has two copies of its header: the sound one of greater generation counts. */
static stp_status read_header(stp_chunk_file *file, bool again, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t file_bytes = stp_byte_source_size(file->source);
    uint8_t bytes[2 * STP_HEADER_BYTES_2] = {0};
    stp_error inner = {0};
    stp_header twin;
    /* A file of another kind may be shorter than a header; the error must still be FORMAT. */
    size_t first = file_bytes < sizeof bytes ? (size_t)file_bytes : sizeof bytes;
    STP_TRY(stp_chunk_file_bytes(file, 0, bytes, first, again, err));
    status = take_header(file, bytes, sizeof bytes, again, &file->header, &inner);
    bool sound = status == STP_OK;
    if (sound && file->header.version_major == 1)
        return STP_OK;
    bool has_twin = first == sizeof bytes &&
                    stp_header_read(bytes + STP_HEADER_BYTES_2, STP_HEADER_BYTES_2, file_bytes,
                                    &twin, NULL) == STP_OK &&
                    twin.version_major > 1;
    /* Copies of one generation are equal. */
    const bool unlike = sound && has_twin && twin.generation == file->header.generation &&
                        memcmp(bytes, bytes + STP_HEADER_BYTES_2, STP_HEADER_BYTES_2) != 0;
    if (has_twin && (!sound || twin.generation > file->header.generation))
        file->header = twin;
    file->info.header_damaged = sound != has_twin || unlike;
    file->info.header_damaged_at = sound ? STP_HEADER_BYTES_2 : 0;
    return sound || has_twin ? STP_OK : locate(file, status, &inner, err);
done:
    return status;
}

/* Whether reading the header again may help: the damage of a copy may have come on the way. */
static bool may_mend_header(const stp_chunk_file *file, stp_status status)
{
    const bool damaged = status == STP_OK && file->info.header_damaged;
    return stp_chunk_file_may_mend(file, damaged ? STP_CORRUPT : status);
}

/* Turns a page's bytes into entries; checks its hash and every entry. */
static stp_status parse_page(const stp_chunk_file *file, uint32_t number, const uint8_t *bytes,
                             page **out, stp_error *err)
{
    stp_status status = STP_OK;
    page *p = NULL;
    stp_error inner = {0};
    size_t hashed = stp_page_bytes(&file->header, number) - STP_HASH_BYTES;
    uint64_t offset = stp_page_offset(&file->header, number);
    if (stp_hash(bytes, hashed) != stp_get_u64(bytes + hashed))
        return stp_error_set(err, STP_CORRUPT,
                             "%s: the checksum of directory page %" PRIu32 " at byte %" PRIu64
                             " does not match: the file is damaged; copy it again",
                             file->path, number, offset);
    STP_TRY(stp_alloc(&p, 1, sizeof *p, "directory page", err));
    for (uint32_t i = 0; i < stp_page_entry_count(&file->header, number); i++) {
        uint64_t place = (uint64_t)i * file->header.entry_bytes;
        status = stp_entry_read(bytes + place, number * STP_PAGE_ENTRIES + i, &file->header,
                                &p->entries[i], &inner);
        if (status != STP_OK) {
            status = stp_error_set(err, status, "%s: byte %" PRIu64 ": %s", file->path,
                                   offset + place, inner.message);
            goto done;
        }
    }
    *out = p;
    p = NULL;
done:
    free(p);
    return status;
}

/* How many pages from `number` on one read brings: one from a file; from a server also the
 * following pages that are not there yet. */
static uint32_t pages_ahead(stp_chunk_file *file, uint32_t number)
{
    uint32_t count = 1;
    size_t bytes = stp_page_bytes(&file->header, number);
    if (!stp_byte_source_is_remote(file->source))
        return count;
    pthread_mutex_lock(&file->mutex);
    while (number + count < file->page_count && !file->pages[number + count]) {
        bytes += stp_page_bytes(&file->header, number + count);
        if (bytes > PAGES_AHEAD_BYTES)
            break;
        count++;
    }
    pthread_mutex_unlock(&file->mutex);
    return count;
}

static size_t pages_bytes(const stp_chunk_file *file, uint32_t number, uint32_t count)
{
    uint64_t begin = stp_page_offset(&file->header, number);
    uint64_t last = stp_page_offset(&file->header, number + count - 1);
    return (size_t)(last - begin) + stp_page_bytes(&file->header, number + count - 1);
}

/* Takes pages that lie together in memory. If two threads read a page at once, the second discards
 * its copy. A fault of another page than the first is reported when that page is asked for. */
static stp_status take_pages(stp_chunk_file *file, uint32_t number, uint32_t count,
                             const uint8_t *bytes, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t begin = stp_page_offset(&file->header, number);
    for (uint32_t i = 0; i < count; i++) {
        page *p = NULL;
        const uint8_t *at = bytes + (stp_page_offset(&file->header, number + i) - begin);
        stp_status one = parse_page(file, number + i, at, &p, i == 0 ? err : NULL);
        status = i == 0 ? one : status;
        if (one != STP_OK)
            continue;
        pthread_mutex_lock(&file->mutex);
        if (!file->pages[number + i]) {
            file->pages[number + i] = p;
            p = NULL;
        }
        pthread_mutex_unlock(&file->mutex);
        free(p);
    }
    return status;
}

/* Reads metadata and first directory page together: they lie side by side. */
static stp_status read_metadata_and_page(stp_chunk_file *file, bool again, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_header *h = &file->header;
    uint8_t *bytes = NULL;
    stp_error inner = {0};
    size_t metadata_bytes = (size_t)h->metadata_bytes;
    uint32_t count = pages_ahead(file, 0);
    size_t size = metadata_bytes + pages_bytes(file, 0, count);
    STP_TRY(stp_alloc(&bytes, size, 1, "metadata and directory", err));
    STP_TRY(stp_chunk_file_bytes(file, h->metadata_offset, bytes, size, again, err));
    if (stp_hash(bytes, metadata_bytes) != h->metadata_hash) {
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: the checksum of the metadata at byte %" PRIu64
                               " does not match: the file is damaged; copy it again",
                               file->path, h->metadata_offset);
        goto done;
    }
    if (file->metadata == NULL)
        STP_TRY(stp_alloc(&file->metadata, metadata_bytes + 1, 1, "metadata", err));
    memcpy(file->metadata, bytes, metadata_bytes);
    status = stp_metadata_check(file->metadata, metadata_bytes, h->point_count, &inner);
    if (status != STP_OK) {
        status = stp_error_set(err, status, "%s: the metadata at byte %" PRIu64 ": %s", file->path,
                               h->metadata_offset, inner.message);
        goto done;
    }
    STP_TRY(take_pages(file, 0, count, bytes + metadata_bytes, err));
done:
    free(bytes);
    return status;
}

static void fill_info(stp_chunk_file *file)
{
    const stp_header *h = &file->header;
    file->info = (stp_chunk_file_info){
        .block_count = stp_header_block_count(h),
        .header_damaged = file->info.header_damaged,
        .header_damaged_at = file->info.header_damaged_at,
        .version_major = h->version_major,
        .version_minor = h->version_minor,
        .file_bytes = h->file_bytes,
        .point_count = h->point_count,
        .chunk_count = h->chunk_count,
        .depth = h->depth,
        .attributes = h->attributes,
        .orientation = (stp_orientation)h->orientation,
        .lambda = h->lambda,
        .box = h->box,
        .metadata_json = file->metadata,
        .metadata_bytes = (size_t)h->metadata_bytes,
        .payloads_begin = stp_header_span(h),
        .payloads_end = stp_payloads_end(h),
    };
}

stp_status stp_chunk_file_open_at(stp_chunk_file **out, const char *path,
                                  const stp_byte_source_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_file *file = NULL;
    STP_TRY(stp_alloc(&file, 1, sizeof *file, "chunk file", err));
    pthread_mutex_init(&file->mutex, NULL);
    STP_TRY(stp_byte_source_open(&file->source, path, params, err));
    file->path = stp_byte_source_name(file->source);
    status = read_header(file, false, err);
    for (int i = 0; i < STP_FRESH_TRIES && may_mend_header(file, status); i++)
        status = read_header(file, true, err);
    STP_TRY(status);
    file->page_count = stp_page_count(&file->header);
    STP_TRY(stp_alloc(&file->pages, file->page_count, sizeof *file->pages, "directory", err));
    status = read_metadata_and_page(file, false, err);
    for (int i = 0; i < STP_FRESH_TRIES && stp_chunk_file_may_mend(file, status); i++)
        status = read_metadata_and_page(file, true, err);
    STP_TRY(status);
    fill_info(file);
    *out = file;
    file = NULL;
done:
    stp_chunk_file_close(&file);
    return status;
}

stp_status stp_chunk_file_open(stp_chunk_file **out, const char *path, stp_error *err)
{
    return stp_chunk_file_open_at(out, path, NULL, err);
}

void stp_chunk_file_close(stp_chunk_file **file)
{
    stp_chunk_file *f = *file;
    if (!f)
        return;
    for (uint32_t i = 0; f->pages && i < f->page_count; i++)
        free(f->pages[i]);
    free(f->pages);
    free(f->metadata);
    free(f->blocks);
    stp_byte_source_close(&f->source);
    pthread_mutex_destroy(&f->mutex);
    free(f);
    *file = NULL;
}

const stp_chunk_file_info *stp_chunk_file_get_info(const stp_chunk_file *file)
{
    return &file->info;
}

const char *stp_chunk_file_path(const stp_chunk_file *file)
{
    return file->path;
}

stp_byte_source *stp_chunk_file_source(stp_chunk_file *file)
{
    return file->source;
}

/* ---- directory ---- */

static page *known_page(stp_chunk_file *file, uint32_t number)
{
    pthread_mutex_lock(&file->mutex);
    page *p = file->pages[number];
    pthread_mutex_unlock(&file->mutex);
    return p;
}

/* Reads a page, and the pages that come with it, outside the lock. */
static stp_status load_page(stp_chunk_file *file, uint32_t number, bool again, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    uint32_t count = again ? 1 : pages_ahead(file, number);
    size_t size = pages_bytes(file, number, count);
    STP_TRY(stp_alloc(&bytes, size, 1, "directory page", err));
    STP_TRY(stp_chunk_file_bytes(file, stp_page_offset(&file->header, number), bytes, size, again,
                                 err));
    STP_TRY(take_pages(file, number, count, bytes, err));
done:
    free(bytes);
    return status;
}

stp_status stp_chunk_file_entry(stp_chunk_file *file, uint32_t id, stp_chunk_entry *out,
                                stp_error *err)
{
    if (id >= file->header.chunk_count)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: chunk %" PRIu32 " is not one of its %" PRIu32, file->path, id,
                             file->header.chunk_count);
    uint32_t number = id / STP_PAGE_ENTRIES;
    page *p = known_page(file, number);
    if (!p) {
        stp_status status = load_page(file, number, false, err);
        for (int i = 0; i < STP_FRESH_TRIES && stp_chunk_file_may_mend(file, status); i++)
            status = load_page(file, number, true, err);
        if (status != STP_OK)
            return status;
        p = known_page(file, number);
    }
    *out = p->entries[id % STP_PAGE_ENTRIES];
    return STP_OK;
}

/* ---- payloads ---- */

uint32_t stp_chunk_payload_bytes(const stp_chunk_entry *entry, int finest_level)
{
    return entry->segment_end[stp_segment_count(finest_level) - 1];
}

/* Whether all segments that lie whole in [begin, end) match their checksums. */
static bool is_sound(const stp_chunk_entry *entry, uint32_t begin, uint32_t end,
                     const uint8_t *bytes)
{
    uint32_t from = 0;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        uint32_t to = entry->segment_end[s];
        if (from >= begin && to <= end &&
            stp_hash(bytes + (from - begin), to - from) != entry->segment_hash[s])
            return false;
        from = to;
    }
    return true;
}

stp_status stp_chunk_file_fetch(stp_chunk_file *file, uint32_t id, uint32_t begin, uint32_t end,
                                uint8_t *out, stp_error *err)
{
    stp_chunk_entry entry;
    stp_status status = stp_chunk_file_entry(file, id, &entry, err);
    if (status != STP_OK)
        return status;
    if (begin > end || end > entry.segment_end[STP_SEGMENT_COUNT - 1])
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "chunk %" PRIu32 ": bytes %" PRIu32 " to %" PRIu32 " are not its own",
                             id, begin, end);
    uint64_t offset = entry.offset + begin;
    status = stp_chunk_file_bytes(file, offset, out, end - begin, false, err);
    for (int i = 0; i < STP_FRESH_TRIES && status == STP_OK &&
                    stp_byte_source_is_remote(file->source) && !is_sound(&entry, begin, end, out);
         i++)
        status = stp_chunk_file_bytes(file, offset, out, end - begin, true, err);
    return status;
}

static stp_status decode_segments(const stp_chunk_file *file, const stp_chunk_entry *entry,
                                  const uint8_t *bytes, stp_chunk *chunk,
                                  stp_chunk_scratch *scratch, stp_error *err)
{
    uint32_t begin = 0;
    for (int s = 0; s < stp_segment_count(chunk->finest_level); s++) {
        stp_error inner = {0};
        uint32_t size = entry->segment_end[s] - begin;
        uint64_t place = entry->offset + begin;
        if (stp_hash(bytes + begin, size) != entry->segment_hash[s])
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: chunk %" PRIu32 ": the checksum of segment %d (%" PRIu32
                                 " bytes at byte %" PRIu64
                                 ") does not match: the file is damaged; copy it again",
                                 file->path, chunk->id, s, size, place);
        stp_status status = stp_segment_decode(bytes + begin, size, s, entry->codec,
                                               entry->child_count, chunk, scratch, &inner);
        if (status != STP_OK)
            return stp_error_set(err, status,
                                 "%s: chunk %" PRIu32 ": segment %d at byte %" PRIu64 ": %s",
                                 file->path, chunk->id, s, place, inner.message);
        begin = entry->segment_end[s];
    }
    return STP_OK;
}

stp_status stp_chunk_file_check(const stp_chunk_file *file, const stp_chunk_entry *entry,
                                const stp_chunk *chunk, stp_error *err)
{
    uint32_t patch = STP_CHUNK_NONE;
    char place[32] = "";
    const char *what = stp_chunk_fault(chunk, entry, file->header.attributes, &patch);
    if (!what)
        return STP_OK;
    if (patch != STP_CHUNK_NONE)
        snprintf(place, sizeof place, "patch %" PRIu32 ": ", patch);
    return stp_error_set(err, STP_CORRUPT,
                         "%s: chunk %" PRIu32 " at byte %" PRIu64
                         ": %s%s: the file was written wrong: prepare the model again",
                         file->path, chunk->id, entry->offset, place, what);
}

stp_status stp_chunk_file_decode(stp_chunk_file *file, uint32_t id, int finest_level,
                                 const uint8_t *payload, stp_chunk_scratch *scratch,
                                 stp_chunk **out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_entry entry;
    stp_chunk *chunk = NULL;
    stp_chunk_scratch own = {0};
    if (finest_level < 0 || finest_level > 2)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "level %d asked for: use 0, 1 or 2",
                             finest_level);
    STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
    STP_TRY(stp_chunk_create_blank(&chunk, entry.patch_count, entry.sample_count, finest_level,
                                   scratch ? scratch : &own, err));
    chunk->id = id;
    chunk->linked = (entry.flags & STP_CHUNK_LINKED) != 0;
    STP_TRY(decode_segments(file, &entry, payload, chunk, scratch ? scratch : &own, err));
    STP_TRY(stp_chunk_file_check(file, &entry, chunk, err));
    *out = chunk;
    chunk = NULL;
done:
    stp_chunk_scratch_free(&own);
    stp_chunk_destroy(&chunk);
    return status;
}

stp_status stp_chunk_file_read(stp_chunk_file *file, uint32_t id, int finest_level, stp_chunk **out,
                               stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_entry entry;
    uint8_t *bytes = NULL;
    STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
    uint32_t size = stp_chunk_payload_bytes(&entry, finest_level);
    /* One byte more, so that even an empty payload has an address. */
    STP_TRY(stp_alloc(&bytes, (size_t)size + 1, 1, "payload", err));
    STP_TRY(stp_chunk_file_fetch(file, id, 0, size, bytes, err));
    STP_TRY(stp_chunk_file_decode(file, id, finest_level, bytes, NULL, out, err));
done:
    free(bytes);
    return status;
}
