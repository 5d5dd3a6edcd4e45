/* The folder of a disk cache: who may write, how many bytes lie there, and how room is made.
 *
 * Ranges are files KEY-OFFSET-SIZE.range in hexadecimal digits. The file `stipple-cache` holds the
 * number of their bytes, and is locked while a process writes. `stipple-cache.part` is the range
 * being written. Nothing else in the folder is touched. Threads: one at a time. */
#ifndef STP_FORMATS_CHUNK_REMOTE_CACHE_FOLDER_H
#define STP_FORMATS_CHUNK_REMOTE_CACHE_FOLDER_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_CACHE_PART_NAME "stipple-cache.part"
/* Including the 0 that ends it. */
#define STP_CACHE_NAME_BYTES 65

typedef struct stp_cache_name {
    uint64_t key[2];
    uint64_t offset;
    uint32_t size;
} stp_cache_name;

void stp_cache_name_write(const stp_cache_name *name, char out[STP_CACHE_NAME_BYTES]);

typedef struct stp_cache_folder {
    int folder; /* descriptors; -1: cannot be opened */
    int count;
} stp_cache_folder;

/* Makes the folder if it is missing. Errors: IO (what could be opened may then still be read). */
stp_status stp_cache_folder_open(stp_cache_folder *out, const char *path, stp_error *err);
void stp_cache_folder_close(stp_cache_folder *f);

/* Calls take for every range there. */
void stp_cache_folder_list(const stp_cache_folder *f,
                           void (*take)(void *context, const stp_cache_name *name), void *context);

/* Waits a while; false if another process keeps the lock. */
bool stp_cache_folder_lock(const stp_cache_folder *f);
void stp_cache_folder_unlock(const stp_cache_folder *f);
/* While locked: counts again what lies there. If it is more than the budget, removes the least
 * lately used files. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_cache_folder_sweep(const stp_cache_folder *f, uint64_t budget, stp_error *err);
/* While locked: makes room for `bytes` more and adds them to the count. *room is false if they can
 * never fit. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_cache_folder_reserve(const stp_cache_folder *f, uint64_t budget, uint64_t bytes,
                                    bool *room, stp_error *err);

#endif
