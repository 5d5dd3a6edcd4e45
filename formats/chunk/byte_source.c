/* The bytes of a chunk file: of a local file, or of an address, with its cache. */
#include "formats/chunk/byte_source.h"

#include "base/checked.h"
#include "base/file.h"
#include "base/memory.h"
#include "formats/chunk/remote/disk_cache.h"
#include "formats/chunk/remote/http.h"

#include <assert.h>
#include <inttypes.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/uio.h>
#include <unistd.h>

/* Reads over a gap of so many bytes in a file rather than calling twice. */
#define GAP_ON_DISK 256u

struct stp_byte_source {
    char *path; /* of a file */
    int descriptor;
    uint64_t size;
    stp_http *http;        /* of an address; NULL: a file */
    stp_disk_cache *cache; /* NULL: none */
    bool unknown_state;    /* a cache was asked for, but the server gives the file no identity */
    atomic_bool cancelled;
    atomic_uint_fast64_t file_bytes, cached_bytes, damaged;
};

/* ---- opening ---- */

/* Opens the cache under a key for this state of the file. A server that does not identify states
 * gets no cache: the file could change unnoticed. */
static stp_status open_cache(stp_byte_source *s, const stp_byte_source_params *params,
                             stp_error *err)
{
    stp_status status = STP_OK;
    char *key = NULL;
    const char *address = stp_http_address(s->http), *identity = stp_http_identity(s->http);
    s->unknown_state = params->cache_folder != NULL && identity[0] == '\0';
    if (params->cache_folder == NULL || s->unknown_state)
        return STP_OK;
    size_t room = strlen(address) + strlen(identity) + 32;
    STP_TRY(stp_alloc(&key, room, 1, "a cache", err));
    snprintf(key, room, "%s\n%s\n%" PRIu64, address, identity, s->size);
    STP_TRY(stp_disk_cache_open(&s->cache, params->cache_folder, params->cache_bytes, key, err));
done:
    free(key);
    return status;
}

static stp_status open_file(stp_byte_source *s, const char *path, stp_error *err)
{
    stp_status status = stp_text_copy(&s->path, path, "path", err);
    return status == STP_OK ? stp_file_open(path, &s->descriptor, &s->size, err) : status;
}

stp_status stp_byte_source_open(stp_byte_source **out, const char *path,
                                const stp_byte_source_params *params, stp_error *err)
{
    static const stp_byte_source_params defaults;
    stp_status status = STP_OK;
    stp_byte_source *s = NULL;
    STP_TRY(stp_alloc(&s, 1, sizeof *s, "a source of bytes", err));
    s->descriptor = -1;
    params = params != NULL ? params : &defaults;
    if (stp_is_address(path)) {
        STP_TRY(stp_http_open(&s->http, path, params, err));
        s->size = stp_http_size(s->http);
        STP_TRY(open_cache(s, params, err));
    } else {
        STP_TRY(open_file(s, path, err));
    }
    *out = s;
    s = NULL;
done:
    stp_byte_source_close(&s);
    return status;
}

void stp_byte_source_close(stp_byte_source **source)
{
    stp_byte_source *s = *source;
    if (s == NULL)
        return;
    stp_disk_cache_close(&s->cache);
    stp_http_close(&s->http);
    if (s->descriptor >= 0)
        close(s->descriptor);
    free(s->path);
    free(s);
    *source = NULL;
}

uint64_t stp_byte_source_size(const stp_byte_source *s)
{
    return s->size;
}

const char *stp_byte_source_name(const stp_byte_source *s)
{
    return s->http != NULL ? stp_http_name(s->http) : s->path;
}

bool stp_byte_source_is_remote(const stp_byte_source *s)
{
    return s->http != NULL;
}

unsigned stp_byte_source_parallel(const stp_byte_source *s)
{
    return s->http != NULL ? STP_SOURCE_CONNECTIONS : 1;
}

/* ---- reading ---- */

/* Takes what is known of a range: from the head of the file, or from the cache. */
static stp_status take_known(stp_byte_source *s, stp_byte_range *r, bool fresh, stp_error *err)
{
    r->got = 0;
    if (!stp_range_inside(r->offset, r->size, s->size))
        return stp_error_set(err, STP_CORRUPT,
                             "%s ends at byte %" PRIu64 ", before byte %" PRIu64
                             ": the file was cut; copy it again",
                             stp_byte_source_name(s), s->size, r->offset + r->size);
    if (!fresh && r->offset + r->size <= STP_HTTP_HEAD_BYTES) {
        memcpy(r->data, stp_http_head(s->http) + r->offset, r->size);
        r->got = r->size;
    } else if (s->cache != NULL && fresh) {
        stp_disk_cache_drop(s->cache, r->offset, r->size);
    } else if (s->cache != NULL) {
        r->got = stp_disk_cache_read(s->cache, r->offset, r->data, r->size);
        atomic_fetch_add(&s->cached_bytes, r->got);
    }
    return STP_OK;
}

static stp_status read_remote(stp_byte_source *s, stp_byte_range *ranges, size_t count, bool fresh,
                              const stp_read_wish *wish, stp_error *err)
{
    stp_status status = STP_OK;
    size_t known[STP_SOURCE_RANGES];
    assert(count <= STP_SOURCE_RANGES);
    for (size_t i = 0; i < count; i++) {
        STP_TRY(take_known(s, &ranges[i], fresh, err));
        known[i] = ranges[i].got;
    }
    status = stp_http_read_ranges(s->http, ranges, count, fresh, wish, err);
    for (size_t i = 0; i < count && s->cache != NULL; i++) {
        const stp_byte_range *r = &ranges[i];
        if (r->got == r->size && known[i] < r->size)
            stp_disk_cache_write(s->cache, r->offset + known[i], r->data + known[i],
                                 r->size - known[i]);
    }
done:
    return status;
}

static stp_status read_file(stp_byte_source *s, stp_byte_range *r, stp_error *err)
{
    r->got = 0;
    if (atomic_load(&s->cancelled))
        return stp_error_set(err, STP_CANCELLED, "%s: reading was interrupted", s->path);
    atomic_fetch_add(&s->file_bytes, r->size);
    const stp_status status =
        stp_file_read_at(s->descriptor, s->path, r->offset, r->data, r->size, err);
    r->got = status == STP_OK ? r->size : 0;
    return status;
}

uint32_t stp_byte_source_gap(const stp_byte_source *s)
{
    return s->http != NULL ? stp_http_gap(s->http) : GAP_ON_DISK;
}

/* Tries to read ranges that lie next to each other, or nearly so, at once. Returns how many these
 * are, from the first on. */
static size_t read_run(stp_byte_source *s, stp_byte_range *ranges, size_t count)
{
    uint8_t unused[GAP_ON_DISK];
    struct iovec pieces[2 * STP_SOURCE_RANGES];
    int piece_count = 0;
    size_t run = 0;
    uint64_t end = ranges[0].offset;
    for (; run < count && ranges[run].offset - end <= GAP_ON_DISK; run++) {
        if (ranges[run].offset > end)
            /* cppcheck-suppress legacyUninitvar ; it is written to */
            pieces[piece_count++] = (struct iovec){unused, (size_t)(ranges[run].offset - end)};
        pieces[piece_count++] = (struct iovec){ranges[run].data, ranges[run].size};
        end = ranges[run].offset + ranges[run].size;
    }
    const uint64_t bytes = end - ranges[0].offset;
    const bool all =
        run > 1 && !atomic_load(&s->cancelled) &&
        preadv(s->descriptor, pieces, piece_count, (off_t)ranges[0].offset) == (ssize_t)bytes;
    for (size_t i = 0; i < run && all; i++)
        ranges[i].got = ranges[i].size;
    atomic_fetch_add(&s->file_bytes, all ? bytes : 0);
    return run;
}

unsigned stp_byte_source_ranges(const stp_byte_source *s)
{
    return s->http != NULL ? stp_http_ranges(s->http) : 1;
}

stp_status stp_byte_source_read_ranges(stp_byte_source *s, stp_byte_range *ranges, size_t count,
                                       const stp_read_wish *wish, stp_error *err)
{
    stp_status first = STP_OK;
    if (s->http != NULL)
        return read_remote(s, ranges, count, false, wish, err);
    for (size_t i = 0; i < count;)
        i += read_run(s, ranges + i, count - i);
    for (size_t i = 0; i < count; i++) {
        const bool there = ranges[i].got == ranges[i].size;
        const stp_status status =
            there ? STP_OK : read_file(s, &ranges[i], first == STP_OK ? err : NULL);
        first = first == STP_OK ? status : first;
    }
    return first;
}

stp_status stp_byte_source_read(stp_byte_source *s, uint64_t offset, void *data, size_t size,
                                stp_error *err)
{
    stp_byte_range range = {.offset = offset, .data = data, .size = size};
    return stp_byte_source_read_ranges(s, &range, 1, NULL, err);
}

stp_status stp_byte_source_reread(stp_byte_source *s, uint64_t offset, void *data, size_t size,
                                  stp_error *err)
{
    stp_byte_range range = {.offset = offset, .data = data, .size = size};
    atomic_fetch_add(&s->damaged, 1);
    return s->http != NULL ? read_remote(s, &range, 1, true, NULL, err) : read_file(s, &range, err);
}

void stp_byte_source_cancel(stp_byte_source *s)
{
    atomic_store(&s->cancelled, true);
    if (s->http != NULL)
        stp_http_cancel(s->http);
}

void stp_byte_source_resume(stp_byte_source *s)
{
    atomic_store(&s->cancelled, false);
    if (s->http != NULL)
        stp_http_resume(s->http);
}

void stp_byte_source_get_stats(stp_byte_source *s, stp_byte_source_stats *out)
{
    *out = (stp_byte_source_stats){.bytes = atomic_load(&s->file_bytes),
                                   .cached_bytes = atomic_load(&s->cached_bytes),
                                   .damaged = atomic_load(&s->damaged)};
    if (s->http != NULL)
        stp_http_add_stats(s->http, out);
    if (s->cache != NULL)
        out->cache_damaged = stp_disk_cache_damaged(s->cache);
}

bool stp_byte_source_note(stp_byte_source *s, stp_error *note)
{
    if (s->unknown_state)
        (void)stp_error_set(note, STP_IO,
                            "%s: the server sends neither ETag nor Last-Modified: nothing is kept "
                            "in the cache",
                            stp_byte_source_name(s));
    return s->unknown_state || (s->cache != NULL && stp_disk_cache_note(s->cache, note));
}
