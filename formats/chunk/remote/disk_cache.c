/* Keeps ranges of a remote file in a folder: finds them by an index in memory, checks them on every
 * reading. */
#include "formats/chunk/remote/disk_cache.h"

#include "base/file.h"
#include "base/memory.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/remote/cache_folder.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#define DEFAULT_BUDGET_BYTES (UINT64_C(1) << 30)
/* A range's file begins with magic, key, offset, size and the xxh3 of the bytes that follow. */
#define RANGE_HEADER_BYTES 48u
#define RANGE_BYTES_LIMIT (4u << 20) /* longer ones are kept in parts */
/* How many ranges that begin earlier a search looks at: they may reach as far. */
#define LOOK_BACK 8

static const uint8_t range_magic[8] = {'S', 'T', 'P', 'R', 'A', 'N', 'G', 'E'};

typedef struct range {
    uint64_t offset;
    uint32_t size;
} range;

struct stp_disk_cache {
    char *path;
    uint64_t key[2];
    uint64_t budget;
    pthread_mutex_t mutex; /* guards ranges, count, capacity, damaged, note, closed; innermost */
    range *ranges;         /* by offset; they may overlap */
    size_t count, capacity;
    uint64_t damaged;
    stp_error note;              /* no message: all is well */
    bool closed;                 /* nothing is written any more */
    pthread_mutex_t write_mutex; /* held while a thread writes; taken before `mutex` */
    stp_cache_folder folder;     /* opened once */
};

/* ---- index; the mutex is held ---- */

/* The first range that begins after offset. */
static size_t find_behind(const stp_disk_cache *c, uint64_t offset)
{
    size_t low = 0, high = c->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (c->ranges[middle].offset <= offset)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Of the ranges that hold the byte at offset, the one that reaches farthest. */
static bool find_range(const stp_disk_cache *c, uint64_t offset, range *out)
{
    size_t behind = find_behind(c, offset);
    uint64_t reach = offset;
    for (size_t i = behind; i > 0 && behind - i < LOOK_BACK; i--) {
        const range *r = &c->ranges[i - 1];
        if (r->offset + r->size > reach) {
            reach = r->offset + r->size;
            *out = *r;
        }
    }
    return reach > offset;
}

static void add_range(stp_disk_cache *c, uint64_t offset, uint32_t size)
{
    size_t at = find_behind(c, offset);
    if (at > 0 && c->ranges[at - 1].offset == offset && c->ranges[at - 1].size == size)
        return;
    if (c->count >= STP_DISK_CACHE_RANGES ||
        stp_grow(&c->ranges, &c->capacity, c->count + 1, sizeof *c->ranges, "the cache", NULL) !=
            STP_OK)
        return; /* the server is then asked again */
    memmove(c->ranges + at + 1, c->ranges + at, (c->count - at) * sizeof *c->ranges);
    c->ranges[at] = (range){offset, size};
    c->count++;
}

static void remove_range(stp_disk_cache *c, const range *gone)
{
    for (size_t i = find_behind(c, gone->offset); i > 0 && c->ranges[i - 1].offset == gone->offset;
         i--) {
        if (c->ranges[i - 1].size != gone->size)
            continue;
        c->count--;
        memmove(c->ranges + i - 1, c->ranges + i, (c->count - (i - 1)) * sizeof *c->ranges);
        return;
    }
}

/* ---- opening ---- */

static void take_range(void *context, const stp_cache_name *name)
{
    stp_disk_cache *c = context;
    if (name->key[0] == c->key[0] && name->key[1] == c->key[1] && name->size > 0 &&
        name->size <= RANGE_BYTES_LIMIT && name->offset <= UINT64_MAX / 2)
        add_range(c, name->offset, name->size);
}

/* Keeps the first reason; nothing is written from then on. */
static void give_up(stp_disk_cache *c, const stp_error *reason)
{
    pthread_mutex_lock(&c->mutex);
    if (!c->closed)
        (void)stp_error_set(&c->note, STP_IO, "%.900s: the model is read without keeping it",
                            reason->message);
    c->closed = true;
    pthread_mutex_unlock(&c->mutex);
}

static void give_up_writing(stp_disk_cache *c, int reason)
{
    stp_error why = {0};
    (void)stp_error_set(&why, STP_IO, "%s: nothing can be kept there: %s", c->path,
                        reason == ENOSPC || reason == EDQUOT ? "the disk is full"
                                                             : strerror(reason));
    give_up(c, &why);
}

stp_status stp_disk_cache_open(stp_disk_cache **out, const char *folder, uint64_t budget_bytes,
                               const char *key, stp_error *err)
{
    stp_status status = STP_OK;
    stp_disk_cache *c = NULL;
    stp_error why = {0};
    STP_TRY(stp_alloc(&c, 1, sizeof *c, "a cache", err));
    c->folder = (stp_cache_folder){-1, -1};
    pthread_mutex_init(&c->mutex, NULL);
    pthread_mutex_init(&c->write_mutex, NULL);
    STP_TRY(stp_text_copy(&c->path, folder, "path", err));
    XXH128_hash_t hash = XXH3_128bits(key, strlen(key));
    c->key[0] = hash.high64;
    c->key[1] = hash.low64;
    c->budget = budget_bytes != 0 ? budget_bytes : DEFAULT_BUDGET_BYTES;
    stp_status opened = stp_cache_folder_open(&c->folder, folder, &why);
    if (opened == STP_OK && stp_cache_folder_lock(&c->folder)) {
        opened = stp_cache_folder_sweep(&c->folder, c->budget, &why);
        stp_cache_folder_unlock(&c->folder);
    }
    if (opened != STP_OK)
        give_up(c, &why);
    stp_cache_folder_list(&c->folder, take_range, c);
    *out = c;
    c = NULL;
done:
    stp_disk_cache_close(&c);
    return status;
}

void stp_disk_cache_close(stp_disk_cache **cache)
{
    stp_disk_cache *c = *cache;
    if (c == NULL)
        return;
    stp_cache_folder_close(&c->folder);
    pthread_mutex_destroy(&c->write_mutex);
    pthread_mutex_destroy(&c->mutex);
    free(c->ranges);
    free(c->path);
    free(c);
    *cache = NULL;
}

/* ---- files ---- */

static stp_cache_name name_of(const stp_disk_cache *c, const range *r)
{
    return (stp_cache_name){{c->key[0], c->key[1]}, r->offset, r->size};
}

static void fill_header(const stp_disk_cache *c, const range *r, const uint8_t *data,
                        uint8_t header[RANGE_HEADER_BYTES])
{
    memcpy(header, range_magic, sizeof range_magic);
    stp_put_u64(header + 8, c->key[0]);
    stp_put_u64(header + 16, c->key[1]);
    stp_put_u64(header + 24, r->offset);
    stp_put_u64(header + 32, r->size);
    stp_put_u64(header + 40, stp_hash(data, r->size));
}

/* Reads and checks the bytes of a range's file. room: the range's size with the header. False if
 * the file is gone; also sets *wrong if it is not what its name says. */
static bool load(const stp_disk_cache *c, const range *r, uint8_t *room, bool *wrong)
{
    char text[STP_CACHE_NAME_BYTES];
    uint8_t header[RANGE_HEADER_BYTES];
    struct stat info;
    stp_cache_name name = name_of(c, r);
    stp_cache_name_write(&name, text);
    int descriptor = openat(c->folder.folder, text, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    *wrong = descriptor < 0 && errno != ENOENT;
    if (descriptor < 0)
        return false;
    *wrong = fstat(descriptor, &info) != 0 || !S_ISREG(info.st_mode) ||
             (uint64_t)info.st_size != (uint64_t)r->size + RANGE_HEADER_BYTES ||
             stp_file_read_at(descriptor, text, 0, room, (size_t)r->size + RANGE_HEADER_BYTES,
                              NULL) != STP_OK;
    if (!*wrong) {
        fill_header(c, r, room + RANGE_HEADER_BYTES, header);
        *wrong = memcmp(header, room, RANGE_HEADER_BYTES) != 0;
    }
    if (!*wrong)
        (void)futimens(descriptor, NULL); /* lately used; fails in a read-only folder */
    close(descriptor);
    return !*wrong;
}

/* Forgets a range, and removes its file if remove_file is set. */
static void forget(stp_disk_cache *c, const range *r, bool remove_file, bool damaged)
{
    char text[STP_CACHE_NAME_BYTES];
    stp_cache_name name = name_of(c, r);
    stp_cache_name_write(&name, text);
    if (remove_file)
        (void)unlinkat(c->folder.folder, text, 0);
    pthread_mutex_lock(&c->mutex);
    remove_range(c, r);
    c->damaged += damaged;
    pthread_mutex_unlock(&c->mutex);
}

size_t stp_disk_cache_read(stp_disk_cache *c, uint64_t offset, uint8_t *data, size_t size)
{
    size_t done = 0;
    while (done < size) {
        range r;
        bool wrong = false;
        pthread_mutex_lock(&c->mutex);
        bool found = find_range(c, offset + done, &r);
        pthread_mutex_unlock(&c->mutex);
        uint8_t *room = found ? malloc((size_t)r.size + RANGE_HEADER_BYTES) : NULL;
        if (room == NULL)
            break;
        if (load(c, &r, room, &wrong)) {
            size_t skip = (size_t)(offset + done - r.offset);
            size_t part = r.size - skip < size - done ? r.size - skip : size - done;
            memcpy(data + done, room + RANGE_HEADER_BYTES + skip, part);
            done += part;
        } else {
            forget(c, &r, wrong, wrong);
        }
        free(room);
    }
    return done;
}

/* ---- keeping ---- */

static bool write_whole(int descriptor, const uint8_t *data, size_t size)
{
    for (size_t put = 0; put < size;) {
        ssize_t part = write(descriptor, data + put, size - put);
        if (part < 0 && errno == EINTR)
            continue;
        if (part <= 0)
            return false;
        put += (size_t)part;
    }
    return true;
}

/* Writes a range's file. The folder must be locked and the room counted. Returns 0 or an errno. */
static int write_file(const stp_disk_cache *c, const range *r, const uint8_t *data)
{
    char text[STP_CACHE_NAME_BYTES];
    uint8_t header[RANGE_HEADER_BYTES];
    stp_cache_name name = name_of(c, r);
    int folder = c->folder.folder;
    stp_cache_name_write(&name, text);
    fill_header(c, r, data, header);
    int descriptor = openat(folder, STP_CACHE_PART_NAME,
                            O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (descriptor < 0)
        return errno;
    bool written =
        write_whole(descriptor, header, sizeof header) && write_whole(descriptor, data, r->size);
    int reason = written ? 0 : errno;
    if (close(descriptor) != 0 && reason == 0)
        reason = errno;
    if (reason == 0 && renameat(folder, STP_CACHE_PART_NAME, folder, text) != 0)
        reason = errno;
    if (reason != 0)
        (void)unlinkat(folder, STP_CACHE_PART_NAME, 0);
    return reason;
}

static void keep(stp_disk_cache *c, const range *r, const uint8_t *data)
{
    stp_error why = {0};
    bool room = false;
    int reason = 0;
    if (!stp_cache_folder_lock(&c->folder))
        return;
    stp_status status = stp_cache_folder_reserve(
        &c->folder, c->budget, (uint64_t)r->size + RANGE_HEADER_BYTES, &room, &why);
    if (status == STP_OK && room)
        reason = write_file(c, r, data);
    stp_cache_folder_unlock(&c->folder);
    if (status != STP_OK)
        give_up(c, &why);
    else if (reason != 0)
        give_up_writing(c, reason);
    else if (room) {
        pthread_mutex_lock(&c->mutex);
        add_range(c, r->offset, r->size);
        pthread_mutex_unlock(&c->mutex);
    }
}

static bool is_closed(stp_disk_cache *c)
{
    pthread_mutex_lock(&c->mutex);
    bool closed = c->closed;
    pthread_mutex_unlock(&c->mutex);
    return closed;
}

void stp_disk_cache_write(stp_disk_cache *c, uint64_t offset, const uint8_t *data, size_t size)
{
    pthread_mutex_lock(&c->write_mutex);
    for (size_t done = 0; done < size && !is_closed(c);) {
        size_t part = size - done < RANGE_BYTES_LIMIT ? size - done : RANGE_BYTES_LIMIT;
        const range r = {offset + done, (uint32_t)part};
        keep(c, &r, data + done);
        done += part;
    }
    pthread_mutex_unlock(&c->write_mutex);
}

void stp_disk_cache_drop(stp_disk_cache *c, uint64_t offset, size_t size)
{
    for (size_t done = 0; done < size;) {
        range r = {0};
        pthread_mutex_lock(&c->mutex);
        bool found = find_range(c, offset + done, &r);
        size_t behind = find_behind(c, offset + done);
        uint64_t next = behind < c->count ? c->ranges[behind].offset : UINT64_MAX;
        pthread_mutex_unlock(&c->mutex);
        if (found)
            forget(c, &r, true, false);
        else if (next - offset >= size)
            break;
        else
            done = (size_t)(next - offset);
    }
}

uint64_t stp_disk_cache_damaged(stp_disk_cache *c)
{
    pthread_mutex_lock(&c->mutex);
    uint64_t damaged = c->damaged;
    pthread_mutex_unlock(&c->mutex);
    return damaged;
}

bool stp_disk_cache_note(stp_disk_cache *c, stp_error *note)
{
    pthread_mutex_lock(&c->mutex);
    bool any = c->note.message[0] != '\0';
    if (any)
        *note = c->note;
    pthread_mutex_unlock(&c->mutex);
    return any;
}
