/* The folder of a disk cache: who may write, how many bytes lie there, and making room.
 *
 * Ranges are files KEY-OFFSET-SIZE.range in hexadecimal digits; `stipple-cache` holds their bytes
 * together and is locked while one writes, `stipple-cache.part` is what is being written. Nothing
 * else in the folder is touched. Threads: one at a time. */
#ifndef STP_FORMATS_CHUNK_REMOTE_CACHE_FOLDER_H
#define STP_FORMATS_CHUNK_REMOTE_CACHE_FOLDER_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_CACHE_PART_NAME "stipple-cache.part"
/* With the 0 that ends it. */
#define STP_CACHE_NAME_BYTES 65

typedef struct stp_cache_name {
    uint64_t key[2];
    uint64_t offset;
    uint32_t size;
} stp_cache_name;

void stp_cache_name_write(const stp_cache_name *name, char out[STP_CACHE_NAME_BYTES]);
/* False for a file that is no range. */
bool stp_cache_name_read(const char *text, stp_cache_name *out);

typedef struct stp_cache_folder {
    int folder; /* descriptors; -1: cannot be opened */
    int count;
} stp_cache_folder;

/* Makes the folder if it is missing. Errors: IO (then what could be opened may still be read). */
stp_status stp_cache_folder_open(stp_cache_folder *out, const char *path, stp_error *err);
void stp_cache_folder_close(stp_cache_folder *f);

/* Calls take for every range there. */
void stp_cache_folder_list(const stp_cache_folder *f,
                           void (*take)(void *context, const stp_cache_name *name), void *context);

/* False if others write for long. */
bool stp_cache_folder_lock(const stp_cache_folder *f);
void stp_cache_folder_unlock(const stp_cache_folder *f);
/* While locked: counts anew what lies there, and removes the least lately used files if it is more
 * than the budget. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_cache_folder_sweep(const stp_cache_folder *f, uint64_t budget, stp_error *err);
/* While locked: counts so many bytes more, once they have room; *room false if they never have.
 * Errors: as sweep. */
stp_status stp_cache_folder_reserve(const stp_cache_folder *f, uint64_t budget, uint64_t bytes,
                                    bool *room, stp_error *err);

#endif
