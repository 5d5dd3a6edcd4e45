/* The chunk file's reader: header, directory pages when asked for, payload segments. */
#include "base/checked.h"
#include "base/file.h"
#include "base/memory.h"
#include "formats/chunk/chunk_file.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/segment.h"

#include <inttypes.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct page {
    stp_chunk_entry entries[STP_PAGE_ENTRIES];
} page;

struct stp_chunk_file {
    int descriptor;
    char *path;
    char *metadata;
    stp_header header;
    stp_chunk_file_info info;
    uint32_t page_count;
    pthread_mutex_t mutex; /* guards the pointers in pages, not what they point to; innermost */
    page **pages;          /* NULL where not read yet; a page never changes once it is there */
};

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

/* ---- opening ---- */

static stp_status read_header(stp_chunk_file *file, uint64_t file_bytes, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t fixed[STP_HEADER_BYTES];
    uint8_t *grown = NULL;
    uint8_t *bytes = fixed;
    uint32_t header_bytes = 0;
    stp_error inner = {0};
    /* A file of another kind may be shorter than a header; it must still be called that. */
    size_t first = file_bytes < sizeof fixed ? (size_t)file_bytes : sizeof fixed;
    memset(fixed, 0, sizeof fixed);
    STP_TRY(stp_file_read_at(file->descriptor, file->path, 0, fixed, first, err));
    status = stp_header_peek(fixed, &header_bytes, &inner);
    if (status != STP_FORMAT && (file_bytes < sizeof fixed || header_bytes > file_bytes))
        return stp_error_set(err, STP_CORRUPT,
                             "%s: it has only %" PRIu64
                             " bytes, less than its header: the file was cut; copy it again",
                             file->path, file_bytes);
    if (status != STP_OK)
        return locate(file, status, &inner, err);
    if (header_bytes > sizeof fixed) {
        STP_TRY(stp_alloc(&grown, header_bytes, 1, "header", err));
        STP_TRY(stp_file_read_at(file->descriptor, file->path, 0, grown, header_bytes, err));
        bytes = grown;
    }
    status = stp_header_read(bytes, header_bytes, file_bytes, &file->header, &inner);
    if (status != STP_OK)
        locate(file, status, &inner, err);
done:
    free(grown);
    return status;
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

/* Metadata and first directory page lie together: one read. */
static stp_status read_metadata_and_page(stp_chunk_file *file, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_header *h = &file->header;
    uint8_t *bytes = NULL;
    size_t metadata_bytes = (size_t)h->metadata_bytes;
    size_t size = metadata_bytes + stp_page_bytes(h, 0);
    STP_TRY(stp_alloc(&bytes, size, 1, "metadata and directory", err));
    STP_TRY(stp_file_read_at(file->descriptor, file->path, h->metadata_offset, bytes, size, err));
    if (stp_hash(bytes, metadata_bytes) != h->metadata_hash) {
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: the checksum of the metadata at byte %" PRIu64
                               " does not match: the file is damaged; copy it again",
                               file->path, h->metadata_offset);
        goto done;
    }
    STP_TRY(stp_alloc(&file->metadata, metadata_bytes + 1, 1, "metadata", err));
    memcpy(file->metadata, bytes, metadata_bytes);
    STP_TRY(parse_page(file, 0, bytes + metadata_bytes, &file->pages[0], err));
done:
    free(bytes);
    return status;
}

static void fill_info(stp_chunk_file *file)
{
    const stp_header *h = &file->header;
    file->info = (stp_chunk_file_info){
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
        .payloads_begin = h->header_bytes,
        .payloads_end = h->metadata_offset,
    };
}

stp_status stp_chunk_file_open(stp_chunk_file **out, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_file *file = NULL;
    uint64_t file_bytes = 0;
    STP_TRY(stp_alloc(&file, 1, sizeof *file, "chunk file", err));
    file->descriptor = -1;
    pthread_mutex_init(&file->mutex, NULL);
    size_t path_bytes = strlen(path) + 1;
    STP_TRY(stp_alloc(&file->path, path_bytes, 1, "path", err));
    memcpy(file->path, path, path_bytes);
    STP_TRY(stp_file_open(path, &file->descriptor, &file_bytes, err));
    STP_TRY(read_header(file, file_bytes, err));
    file->page_count = stp_page_count(&file->header);
    STP_TRY(stp_alloc(&file->pages, file->page_count, sizeof *file->pages, "directory", err));
    STP_TRY(read_metadata_and_page(file, err));
    fill_info(file);
    *out = file;
    file = NULL;
done:
    stp_chunk_file_close(&file);
    return status;
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
    free(f->path);
    if (f->descriptor >= 0)
        close(f->descriptor);
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

/* ---- directory ---- */

static page *known_page(stp_chunk_file *file, uint32_t number)
{
    pthread_mutex_lock(&file->mutex);
    page *p = file->pages[number];
    pthread_mutex_unlock(&file->mutex);
    return p;
}

/* Reads a page outside the lock; of two threads that do so at once, the second throws its away. */
static stp_status load_page(stp_chunk_file *file, uint32_t number, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    page *p = NULL;
    size_t size = stp_page_bytes(&file->header, number);
    STP_TRY(stp_alloc(&bytes, size, 1, "directory page", err));
    STP_TRY(stp_file_read_at(file->descriptor, file->path, stp_page_offset(&file->header, number),
                             bytes, size, err));
    STP_TRY(parse_page(file, number, bytes, &p, err));
    pthread_mutex_lock(&file->mutex);
    if (!file->pages[number]) {
        file->pages[number] = p;
        p = NULL;
    }
    pthread_mutex_unlock(&file->mutex);
done:
    free(p);
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
        stp_status status = load_page(file, number, err);
        if (status != STP_OK)
            return status;
        p = known_page(file, number);
    }
    *out = p->entries[id % STP_PAGE_ENTRIES];
    return STP_OK;
}

/* ---- payloads ---- */

static int last_segment(int finest_level)
{
    return finest_level >= 2 ? 0 : finest_level == 1 ? 1 : 2;
}

uint32_t stp_chunk_payload_bytes(const stp_chunk_entry *entry, int finest_level)
{
    return entry->segment_end[last_segment(finest_level)];
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
    return stp_file_read_at(file->descriptor, file->path, entry.offset + begin, out, end - begin,
                            err);
}

static stp_status decode_segments(const stp_chunk_file *file, const stp_chunk_entry *entry,
                                  const uint8_t *bytes, stp_chunk *chunk, stp_error *err)
{
    uint32_t begin = 0;
    for (int s = 0; s <= last_segment(chunk->finest_level); s++) {
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
                                               entry->child_count, chunk, &inner);
        if (status != STP_OK)
            return stp_error_set(err, status,
                                 "%s: chunk %" PRIu32 ": segment %d at byte %" PRIu64 ": %s",
                                 file->path, chunk->id, s, place, inner.message);
        begin = entry->segment_end[s];
    }
    return STP_OK;
}

stp_status stp_chunk_file_decode(stp_chunk_file *file, uint32_t id, int finest_level,
                                 const uint8_t *payload, stp_chunk **out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_entry entry;
    stp_chunk *chunk = NULL;
    if (finest_level < 0 || finest_level > 2)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "level %d asked for: use 0, 1 or 2",
                             finest_level);
    STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
    STP_TRY(stp_chunk_create(&chunk, entry.patch_count, entry.sample_count, finest_level, err));
    chunk->id = id;
    STP_TRY(decode_segments(file, &entry, payload, chunk, err));
    *out = chunk;
    chunk = NULL;
done:
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
    /* One more, so that even an empty payload has a place in memory. */
    STP_TRY(stp_alloc(&bytes, (size_t)size + 1, 1, "payload", err));
    STP_TRY(stp_chunk_file_fetch(file, id, 0, size, bytes, err));
    STP_TRY(stp_chunk_file_decode(file, id, finest_level, bytes, out, err));
done:
    free(bytes);
    return status;
}
