/* Arrays in mapped files. */
#include "base/spill.h"

#include "base/checked.h"
#include "base/memory.h"
#include "base/temporary.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

/* How often the watching thread looks at the process's memory. Pages are dropped when the process
 * comes within a margin of the limit: a part of the limit, and at least what threads can touch
 * while the watching thread waits for its turn. */
#define WATCH_NS 1000000
#define MARGIN_PART 10
#define MARGIN_BYTES (64u << 20)
/* Pages are dropped slice by slice, in turn, until half a margin more is free. Dropping all at once
 * takes so long that as many pages come back meanwhile. */
#define SLICE_BYTES ((size_t)16 << 20)

/* Arrays up to SMALL_BYTES share files of FILE_BYTES. A system allows a process some ten thousands
 * of mappings, and a large model has more chunks than that. */
#define FILE_BYTES ((size_t)8 << 20)
#define SMALL_BYTES ((size_t)2 << 20)
#define ALIGN_BYTES ((size_t)64)

typedef struct mapping {
    void *memory;
    size_t bytes, used, forgotten;
    uint32_t array_count; /* arrays in use; the file is freed with the last one */
    int file;             /* of a sparse array, which begins all forgotten; else -1 */
    bool own;             /* lies in no file though there is a limit: never dropped */
    size_t filled;        /* bytes from the start that have been written, and are read ahead */
} mapping;

struct stp_spill {
    char *folder; /* NULL: plain memory */
    uint64_t memory_bytes, own_most;
    pthread_t watcher;
    bool watching;

    pthread_mutex_t mutex; /* guards everything below; the only lock */
    pthread_cond_t ended;
    bool ending;
    mapping *mappings;
    size_t count, capacity;
    void *shared;             /* memory of the mapping that takes small arrays; NULL: none */
    size_t turn, turn_offset; /* where the next slice begins: a mapping, and bytes into it */
    uint64_t file_bytes, most_file_bytes, own_bytes;
};

/* Bytes that the process holds in memory; 0 if the system does not say. */
static uint64_t resident_bytes(void)
{
    unsigned long pages = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file)
        return 0;
    if (fscanf(file, "%lu %lu", &pages, &resident) != 2)
        resident = 0;
    fclose(file);
    return (uint64_t)resident * (uint64_t)sysconf(_SC_PAGESIZE);
}

/* If a slice is filled, lets the system read it ahead when it comes back from the disk. While a
 * file is filled this is off (MADV_RANDOM): else the system takes large blocks of pages for it, and
 * one touch of such a block counts as memory as a whole. */
static void read_ahead(mapping *m, size_t offset, size_t bytes)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE); /* 4096 or more */
    unsigned char cached[SLICE_BYTES / 4096];
    if (offset != m->filled || mincore((char *)m->memory + offset, bytes, cached) != 0)
        return;
    for (size_t i = 0; i * page < bytes; i++)
        if (!(cached[i] & 1))
            return;
    (void)madvise((char *)m->memory + offset, bytes, MADV_NORMAL);
    m->filled += bytes;
}

/* Drops the next slice of all mappings, in turn. Returns its size. Other threads may be using these
 * pages: their next touch brings the pages back. */
static size_t let_go_slice(stp_spill *s)
{
    if (s->turn >= s->count)
        s->turn = s->turn_offset = 0;
    mapping *m = &s->mappings[s->turn];
    size_t left = !m->own && s->turn_offset < m->bytes ? m->bytes - s->turn_offset : 0;
    size_t bytes = left < SLICE_BYTES ? left : SLICE_BYTES;
    if (bytes > 0) {
        (void)madvise((char *)m->memory + s->turn_offset, bytes, MADV_DONTNEED);
        read_ahead(m, s->turn_offset, bytes);
    }
    s->turn_offset += bytes;
    if (m->own || s->turn_offset >= m->bytes) {
        s->turn++;
        s->turn_offset = 0;
    }
    return bytes;
}

/* Called with the mutex held. */
static void relieve(stp_spill *s)
{
    uint64_t margin = s->memory_bytes / MARGIN_PART;
    margin = margin > MARGIN_BYTES ? margin : MARGIN_BYTES;
    uint64_t most = s->memory_bytes > 2 * margin ? s->memory_bytes - margin : s->memory_bytes / 2;
    uint64_t gone = 0;
    if (s->count == 0 || resident_bytes() <= most)
        return;
    while (gone < s->file_bytes && resident_bytes() > most - margin / 2)
        gone += let_go_slice(s);
}

void stp_spill_relieve(stp_spill *s)
{
    if (!s || !s->folder)
        return;
    pthread_mutex_lock(&s->mutex);
    relieve(s);
    pthread_mutex_unlock(&s->mutex);
}

static void *watch(void *argument)
{
    stp_spill *s = argument;
    pthread_mutex_lock(&s->mutex);
    while (!s->ending) {
        struct timespec until;
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_nsec += WATCH_NS;
        until.tv_sec += until.tv_nsec / 1000000000;
        until.tv_nsec %= 1000000000;
        pthread_cond_timedwait(&s->ended, &s->mutex, &until);
        relieve(s);
    }
    pthread_mutex_unlock(&s->mutex);
    return NULL;
}

static stp_status io_error(const stp_spill *s, const char *doing, int code, uint64_t bytes,
                           const char *what, stp_error *err)
{
    if (code == ENOSPC || code == EDQUOT)
        return stp_error_set(err, STP_IO,
                             "%s: no room for %.2f GB of temporary files (%s) beside %.2f GB that "
                             "are there: free some or give another folder (--temp)",
                             s->folder, 1e-9 * (double)bytes, what, 1e-9 * (double)s->file_bytes);
    return stp_error_set(err, STP_IO,
                         "%s: %s a temporary file failed: %s: give another folder (--temp)",
                         s->folder, doing, strerror(code));
}

static void count_bytes(stp_spill *s, size_t more)
{
    s->file_bytes += more;
    s->most_file_bytes = s->file_bytes > s->most_file_bytes ? s->file_bytes : s->most_file_bytes;
}

/* Called with the mutex held. */
static stp_status map_file(stp_spill *s, size_t bytes, bool sparse, const char *what,
                           stp_error *err)
{
    stp_status status = stp_grow(&s->mappings, &s->capacity, s->count + 1, sizeof *s->mappings,
                                 "temporary files", err);
    if (status != STP_OK)
        return status;
    int descriptor = stp_temporary_nameless(s->folder);
    if (descriptor < 0)
        return io_error(s, "making", errno, bytes, what, err);
    int code = !sparse ? posix_fallocate(descriptor, 0, (off_t)bytes)
               : ftruncate(descriptor, (off_t)bytes) != 0 ? errno
                                                          : 0;
    void *memory = MAP_FAILED;
    if (code == 0) {
        memory = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
        code = memory == MAP_FAILED ? errno : 0;
    }
    if (code == 0)
        (void)madvise(memory, bytes, MADV_RANDOM);
    if (!sparse || code != 0)
        close(descriptor); /* the mapping keeps the file */
    if (code != 0)
        return io_error(s, "growing", code, bytes, what, err);
    s->mappings[s->count++] = (mapping){.memory = memory,
                                        .bytes = bytes,
                                        .forgotten = sparse ? bytes : 0,
                                        .file = sparse ? descriptor : -1};
    count_bytes(s, sparse ? 0 : bytes);
    return STP_OK;
}

/* Maps memory that lies in no file: the system gives a page when it is touched. Called with the
 * mutex held. */
static stp_status map_memory(stp_spill *s, size_t bytes, bool sparse, const char *what,
                             stp_error *err)
{
    stp_status status = stp_grow(&s->mappings, &s->capacity, s->count + 1, sizeof *s->mappings,
                                 "temporary files", err);
    if (status != STP_OK)
        return status;
    void *memory = mmap(NULL, bytes, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS | (sparse ? MAP_NORESERVE : 0), -1, 0);
    if (memory == MAP_FAILED)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no room for %zu bytes of %s", bytes, what);
    if (sparse) /* large pages would fill what nobody touches */
        (void)madvise(memory, bytes, MADV_NOHUGEPAGE);
    s->mappings[s->count++] = (mapping){
        .memory = memory, .bytes = bytes, .forgotten = sparse ? bytes : 0, .file = -1, .own = true};
    s->own_bytes += bytes;
    return STP_OK;
}

/* Finds room for an array in memory, in a file of its own or in the shared one. Called with the
 * mutex held. */
static stp_status take_room(stp_spill *s, size_t bytes, const char *what, void **out,
                            stp_error *err)
{
    bool small = bytes <= SMALL_BYTES;
    size_t padded = small ? (bytes + ALIGN_BYTES - 1) / ALIGN_BYTES * ALIGN_BYTES : bytes;
    mapping *m = NULL;
    for (size_t i = s->count; small && s->shared && i-- > 0 && !m;)
        if (s->mappings[i].memory == s->shared)
            m = &s->mappings[i];
    if (!m || m->bytes - m->used < padded) {
        const size_t size = small ? FILE_BYTES : bytes;
        const bool own = s->own_bytes < s->own_most && size <= s->own_most - s->own_bytes;
        stp_status status =
            own ? map_memory(s, size, false, what, err) : map_file(s, size, false, what, err);
        if (status != STP_OK)
            return status;
        m = &s->mappings[s->count - 1];
        s->shared = small ? m->memory : s->shared;
    }
    *out = (char *)m->memory + m->used;
    m->used += padded;
    m->array_count++;
    return STP_OK;
}

/* Starts the watching thread. Tries first whether files can be made in the folder, so that the user
 * learns it before hours of work. */
static stp_status start_watching(stp_spill *s, const char *folder, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_text_copy(&s->folder, folder, "a path", err));
    int descriptor = stp_temporary_nameless(folder);
    if (descriptor < 0)
        return io_error(s, "making", errno, 0, "a first try", err);
    close(descriptor);
    if (pthread_create(&s->watcher, NULL, watch, s) != 0)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for a thread");
    s->watching = true;
done:
    return status;
}

stp_status stp_spill_create(stp_spill **out, const stp_spill_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_spill *s = NULL;
    STP_TRY(stp_alloc(&s, 1, sizeof *s, "temporary files", err));
    pthread_mutex_init(&s->mutex, NULL);
    pthread_cond_init(&s->ended, NULL);
    s->memory_bytes = params->memory_bytes;
    s->own_most = params->own_bytes;
    if (params->memory_bytes > 0)
        STP_TRY(start_watching(s, params->folder, err));
    *out = s;
    s = NULL;
done:
    stp_spill_destroy(&s);
    return status;
}

static void unmap(const mapping *m)
{
    munmap(m->memory, m->bytes);
    if (m->file >= 0)
        close(m->file);
}

void stp_spill_destroy(stp_spill **spill)
{
    stp_spill *s = *spill;
    if (!s)
        return;
    if (s->watching) {
        pthread_mutex_lock(&s->mutex);
        s->ending = true;
        pthread_cond_signal(&s->ended);
        pthread_mutex_unlock(&s->mutex);
        pthread_join(s->watcher, NULL);
    }
    for (size_t i = 0; i < s->count; i++)
        unmap(&s->mappings[i]);
    free(s->mappings);
    free(s->folder);
    pthread_cond_destroy(&s->ended);
    pthread_mutex_destroy(&s->mutex);
    free(s);
    *spill = NULL;
}

stp_status stp_spill_alloc(stp_spill *s, void *out, size_t count, size_t size, const char *what,
                           stp_error *err)
{
    size_t bytes = 0;
    void *memory = NULL;
    if (!s || !s->folder || count == 0)
        return stp_alloc(out, count, size, what, err);
    if (!stp_mul_size(count, size, &bytes))
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for %zu %s", count, what);
    pthread_mutex_lock(&s->mutex);
    stp_status status = take_room(s, bytes, what, &memory, err);
    pthread_mutex_unlock(&s->mutex);
    if (status == STP_OK)
        memcpy(out, &memory, sizeof memory);
    return status;
}

stp_status stp_spill_alloc_sparse(stp_spill *s, void *out, size_t count, size_t size,
                                  const char *what, stp_error *err)
{
    size_t bytes = 0;
    if (!s || count == 0)
        return stp_alloc(out, count, size, what, err);
    if (!stp_mul_size(count, size, &bytes))
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for %zu %s", count, what);
    pthread_mutex_lock(&s->mutex);
    const stp_status status =
        s->folder ? map_file(s, bytes, true, what, err) : map_memory(s, bytes, true, what, err);
    if (status == STP_OK) {
        mapping *m = &s->mappings[s->count - 1];
        m->array_count = 1;
        memcpy(out, &m->memory, sizeof m->memory);
    }
    pthread_mutex_unlock(&s->mutex);
    return status;
}

stp_status stp_spill_move(stp_spill *s, void *array, size_t count, size_t size, const char *what,
                          stp_error *err)
{
    stp_status status = STP_OK;
    void *old = NULL, *moved = NULL;
    memcpy(&old, array, sizeof old);
    if (!s || !s->folder || !old)
        return STP_OK;
    STP_TRY(stp_spill_alloc(s, &moved, count, size, what, err));
    if (count > 0)
        memcpy(moved, old, count * size);
    memcpy(array, &moved, sizeof moved);
    free(old);
done:
    return status;
}

/* The mapping an array lies in; NULL if it is plain memory. */
static mapping *mapping_of(const stp_spill *s, const void *array)
{
    for (size_t i = s->count; i-- > 0;)
        if ((uintptr_t)array - (uintptr_t)s->mappings[i].memory < s->mappings[i].bytes)
            return &s->mappings[i];
    return NULL;
}

/* Gives up an array's room. False if the array is not in a file. */
static bool give_room(stp_spill *s, const void *array)
{
    mapping *m = mapping_of(s, array);
    if (!m || --m->array_count > 0)
        return m != NULL;
    if (m->memory == s->shared)
        s->shared = NULL;
    unmap(m);
    if (m->own)
        s->own_bytes -= m->bytes;
    else
        s->file_bytes -= m->bytes - m->forgotten;
    *m = s->mappings[--s->count];
    return true;
}

void stp_spill_free(stp_spill *s, void *array)
{
    bool in_file = false;
    if (s && array) {
        pthread_mutex_lock(&s->mutex);
        in_file = give_room(s, array);
        pthread_mutex_unlock(&s->mutex);
    }
    if (!in_file)
        free(array);
}

void stp_spill_forget(stp_spill *s, void *part, size_t bytes)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    const size_t before = (page - (uintptr_t)part % page) % page; /* the first whole page */
    if (!s || bytes < before + page)
        return;
    char *begin = (char *)part + before;
    const size_t whole = (bytes - before) / page * page;
    pthread_mutex_lock(&s->mutex);
    mapping *m = mapping_of(s, part);
    if (m && madvise(begin, whole, m->own ? MADV_DONTNEED : MADV_REMOVE) == 0) {
        m->forgotten += whole;
        s->file_bytes -= m->own ? 0 : whole;
    }
    pthread_mutex_unlock(&s->mutex);
}

stp_status stp_spill_claim(stp_spill *s, void *part, size_t bytes, const char *what, stp_error *err)
{
    stp_status status = STP_OK;
    if (!s || bytes == 0)
        return STP_OK;
    pthread_mutex_lock(&s->mutex);
    mapping *m = mapping_of(s, part);
    const size_t more = m && bytes > m->forgotten ? m->forgotten : bytes;
    if (m && m->file >= 0) {
        const off_t at = (off_t)((uintptr_t)part - (uintptr_t)m->memory);
        const int code = posix_fallocate(m->file, at, (off_t)bytes);
        if (code != 0)
            status = io_error(s, "growing", code, bytes, what, err);
        else
            count_bytes(s, more);
    }
    if (m && status == STP_OK)
        m->forgotten -= more;
    pthread_mutex_unlock(&s->mutex);
    return status;
}

uint64_t stp_spill_most_file_bytes(stp_spill *s)
{
    if (!s)
        return 0;
    pthread_mutex_lock(&s->mutex);
    uint64_t bytes = s->most_file_bytes;
    pthread_mutex_unlock(&s->mutex);
    return bytes;
}
