/* The folder of a disk cache: lock, count, and room made by removing what was unused for longest.
 */
#include "formats/chunk/remote/cache_folder.h"

#include "base/file.h"
#include "base/memory.h"
#include "formats/chunk/layout.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define COUNT_NAME "stipple-cache"
#define COUNT_BYTES 16
#define LOCK_TRIES 40
#define LOCK_PAUSE_NS 5000000L

static const uint8_t count_magic[8] = {'S', 'T', 'P', 'C', 'A', 'C', 'H', 'E'};

typedef struct old_file {
    stp_cache_name name;
    uint64_t bytes;
    struct timespec used;
} old_file;

typedef struct old_files {
    const stp_cache_folder *folder;
    old_file *list;
    size_t count, capacity;
    uint64_t bytes;
    stp_status status;
    stp_error *err;
} old_files;

/* ---- names ---- */

void stp_cache_name_write(const stp_cache_name *name, char out[STP_CACHE_NAME_BYTES])
{
    snprintf(out, STP_CACHE_NAME_BYTES,
             "%016" PRIx64 "%016" PRIx64 "-%016" PRIx64 "-%08" PRIx32 ".range", name->key[0],
             name->key[1], name->offset, name->size);
}

/* Reads the digits of one number. A character that is no digit gives a number whose name differs
 * from the text. */
static uint64_t hexadecimal(const char *text, size_t digits)
{
    char copy[17] = {0};
    memcpy(copy, text, digits);
    return strtoull(copy, NULL, 16);
}

/* False if the file is no range. */
static bool read_name(const char *text, stp_cache_name *out)
{
    char again[STP_CACHE_NAME_BYTES];
    if (strlen(text) != STP_CACHE_NAME_BYTES - 1)
        return false;
    *out = (stp_cache_name){{hexadecimal(text, 16), hexadecimal(text + 16, 16)},
                            hexadecimal(text + 33, 16),
                            (uint32_t)hexadecimal(text + 50, 8)};
    stp_cache_name_write(out, again);
    return strcmp(again, text) == 0;
}

/* ---- opening ---- */

static stp_status say_closed(const char *path, int reason, stp_error *err)
{
    return stp_error_set(err, STP_IO, "%s: nothing can be kept there: %s", path, strerror(reason));
}

stp_status stp_cache_folder_open(stp_cache_folder *out, const char *path, stp_error *err)
{
    *out = (stp_cache_folder){-1, -1};
    if (stp_folder_make(path, 0700, NULL) != STP_OK)
        return say_closed(path, errno, err);
    out->folder = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (out->folder < 0)
        return say_closed(path, errno, err);
    out->count = openat(out->folder, COUNT_NAME, O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600);
    return out->count < 0 ? say_closed(path, errno, err) : STP_OK;
}

void stp_cache_folder_close(stp_cache_folder *f)
{
    if (f->count >= 0)
        close(f->count);
    if (f->folder >= 0)
        close(f->folder);
    *f = (stp_cache_folder){-1, -1};
}

void stp_cache_folder_list(const stp_cache_folder *f,
                           void (*take)(void *context, const stp_cache_name *name), void *context)
{
    /* a descriptor of its own: closedir closes it, and a copy would share its read position */
    int again = f->folder >= 0 ? openat(f->folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    DIR *folder = again >= 0 ? fdopendir(again) : NULL;
    stp_cache_name name;
    if (folder == NULL) {
        if (again >= 0)
            close(again);
        return;
    }
    for (struct dirent *e = readdir(folder); e != NULL; e = readdir(folder))
        if (read_name(e->d_name, &name))
            take(context, &name);
    closedir(folder);
}

/* ---- lock and count ---- */

bool stp_cache_folder_lock(const stp_cache_folder *f)
{
    const struct timespec pause = {0, LOCK_PAUSE_NS};
    for (int i = 0; f->count >= 0 && i < LOCK_TRIES; i++) {
        if (flock(f->count, LOCK_EX | LOCK_NB) == 0)
            return true;
        nanosleep(&pause, NULL);
    }
    return false;
}

void stp_cache_folder_unlock(const stp_cache_folder *f)
{
    (void)flock(f->count, LOCK_UN);
}

static bool read_count(const stp_cache_folder *f, uint64_t *bytes)
{
    uint8_t text[COUNT_BYTES];
    if (pread(f->count, text, sizeof text, 0) != COUNT_BYTES ||
        memcmp(text, count_magic, sizeof count_magic) != 0)
        return false;
    *bytes = stp_get_u64(text + 8);
    return true;
}

static stp_status write_count(const stp_cache_folder *f, uint64_t bytes, stp_error *err)
{
    uint8_t text[COUNT_BYTES];
    memcpy(text, count_magic, sizeof count_magic);
    stp_put_u64(text + 8, bytes);
    if (pwrite(f->count, text, sizeof text, 0) == COUNT_BYTES)
        return STP_OK;
    return stp_error_set(err, STP_IO, "%s: %s", COUNT_NAME, strerror(errno));
}

/* ---- room ---- */

static void take_old(void *context, const stp_cache_name *name)
{
    old_files *all = context;
    char text[STP_CACHE_NAME_BYTES];
    struct stat info;
    stp_cache_name_write(name, text);
    if (fstatat(all->folder->folder, text, &info, AT_SYMLINK_NOFOLLOW) != 0)
        return;
    if (all->status == STP_OK)
        all->status = stp_grow(&all->list, &all->capacity, all->count + 1, sizeof *all->list,
                               "the cache's files", all->err);
    if (all->status != STP_OK)
        return;
    all->list[all->count++] = (old_file){*name, (uint64_t)info.st_size, info.st_mtim};
    all->bytes += (uint64_t)info.st_size;
}

static int by_use(const void *a, const void *b)
{
    const struct timespec *x = &((const old_file *)a)->used, *y = &((const old_file *)b)->used;
    if (x->tv_sec != y->tv_sec)
        return x->tv_sec < y->tv_sec ? -1 : 1;
    return (x->tv_nsec > y->tv_nsec) - (x->tv_nsec < y->tv_nsec);
}

/* Removes files until at most `most` bytes are left. *left: how many are. */
static stp_status leave(const stp_cache_folder *f, uint64_t budget, uint64_t most, uint64_t *left,
                        stp_error *err)
{
    old_files all = {.folder = f, .err = err};
    char text[STP_CACHE_NAME_BYTES];
    (void)unlinkat(f->folder, STP_CACHE_PART_NAME, 0); /* left by a process that was killed */
    stp_cache_folder_list(f, take_old, &all);
    if (all.status == STP_OK && all.bytes > budget) {
        qsort(all.list, all.count, sizeof *all.list, by_use);
        for (size_t i = 0; i < all.count && all.bytes > most; i++) {
            stp_cache_name_write(&all.list[i].name, text);
            if (unlinkat(f->folder, text, 0) == 0)
                all.bytes -= all.list[i].bytes;
        }
    }
    *left = all.bytes;
    free(all.list);
    return all.status;
}

stp_status stp_cache_folder_sweep(const stp_cache_folder *f, uint64_t budget, stp_error *err)
{
    uint64_t left = 0;
    stp_status status = leave(f, budget, budget, &left, err);
    return status == STP_OK ? write_count(f, left, err) : status;
}

stp_status stp_cache_folder_reserve(const stp_cache_folder *f, uint64_t budget, uint64_t bytes,
                                    bool *room, stp_error *err)
{
    uint64_t there = 0;
    *room = bytes <= budget;
    if (!*room)
        return STP_OK;
    if (!read_count(f, &there) || there > budget - bytes) {
        /* removes some more, so that not every range has to make room again */
        uint64_t most = budget - bytes < budget / 8 * 7 ? budget - bytes : budget / 8 * 7;
        stp_status status = leave(f, budget - bytes, most, &there, err);
        if (status != STP_OK)
            return status;
        *room = there <= budget - bytes;
    }
    return *room ? write_count(f, there + bytes, err) : STP_OK;
}
