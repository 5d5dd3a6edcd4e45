/* Keeps ranges of remote files in a folder of the user's.
 *
 * Each range is a file of its own. Its name has a hash of address and state on the server, its
 * offset and its size. Its checksum is compared on every reading; a file that is damaged or of
 * another kind is dropped. All ranges together stay within the budget: the least lately used go
 * first. Several processes may share a folder: one writes at a time (a lock on the file
 * `stipple-cache`, which counts the bytes), and names appear whole. Files of other names are left
 * alone. The cache never gets in the way: if it cannot be read or written, it keeps less, and a
 * note says why. Memory: 16 bytes for each range of this file, at most STP_DISK_CACHE_RANGES of
 * them, and the range being read. Threads: any. */
#ifndef STP_FORMATS_CHUNK_REMOTE_DISK_CACHE_H
#define STP_FORMATS_CHUNK_REMOTE_DISK_CACHE_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_DISK_CACHE_RANGES (1u << 20)

typedef struct stp_disk_cache stp_disk_cache;

/* Makes the folder if it is missing, and removes ranges if the budget is smaller than what is
 * there. key: tells this state of this file from all others. Errors: OUT_OF_MEMORY. */
stp_status stp_disk_cache_open(stp_disk_cache **out, const char *folder, uint64_t budget_bytes,
                               const char *key, stp_error *err);
void stp_disk_cache_close(stp_disk_cache **cache);

/* Fills data from its beginning, as far as ranges are there. Returns how many bytes. */
size_t stp_disk_cache_read(stp_disk_cache *cache, uint64_t offset, uint8_t *data, size_t size);
/* Keeps a range, if room can be made for it. */
void stp_disk_cache_write(stp_disk_cache *cache, uint64_t offset, const uint8_t *data, size_t size);
/* Forgets all ranges that overlap this one. */
void stp_disk_cache_drop(stp_disk_cache *cache, uint64_t offset, size_t size);

/* Number of files that were damaged or of another kind, and dropped. */
uint64_t stp_disk_cache_damaged(stp_disk_cache *cache);
/* Why the cache keeps nothing, as a sentence; false if all is well. */
bool stp_disk_cache_note(stp_disk_cache *cache, stp_error *note);

#endif
