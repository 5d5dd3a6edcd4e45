/* The bytes of a chunk file: a local file, or an http:// or https:// address that is read by
 * ranges, with a folder of the user's as a cache if one is given.
 *
 * Knows nothing of chunks. Offsets and sizes in bytes. Threads: several may read at once, and as
 * many requests are then in flight; any may cancel; close when no read runs any more.
 *
 * A remote read is one request for the range. It is retried, from the last byte that came, if it is
 * cut, answered by 429, 500, 502, 503 or 504, or if nothing comes for stall_ms: after a pause that
 * doubles, at most `tries` times in all. It ends at once if the file changed on the server, if the
 * server has no ranges or sends wrong ones, and for all other answers. Every try ends after
 * connect_ms, then stall_ms, plus a second for each KiB asked for. Each pause takes at most
 * STP_SOURCE_PAUSE_LIMIT_MS. If patience_ms is given, all reads end with IO once they have waited
 * for the source that long in all, plus a second for each KiB and each answer that came. If a
 * server refuses a request by 429 or 503, or closes one of several connections, fewer requests are
 * in flight from then on. The latter does not count as a try, and is mended without a pause. */
#ifndef STP_FORMATS_CHUNK_BYTE_SOURCE_H
#define STP_FORMATS_CHUNK_BYTE_SOURCE_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Connections to a server: as many requests are in flight at most. Small ranges fill a line only if
 * many are on their way: 16 ranges of 11 KB fill 20 Mbit/s with answers after 60 ms. */
#define STP_SOURCE_CONNECTIONS 16u
/* If a server asks for a longer pause (Retry-After), the read ends and says so. */
#define STP_SOURCE_PAUSE_LIMIT_MS 20000u

typedef struct stp_byte_source stp_byte_source;

/* For addresses; a local file needs none of them. Strings are borrowed until open returns. */
typedef struct stp_byte_source_params {
    const char *cache_folder; /* made if missing; NULL: no cache */
    uint64_t cache_bytes;     /* of all files in the folder together; 0: 1 GiB */
    unsigned connect_ms;      /* until a connection is made; 0: 10,000 */
    unsigned stall_ms;        /* without a byte; 0: 10,000 */
    unsigned tries;           /* of a request; 0: 4 */
    unsigned pause_ms;        /* before the second try, half of it random; 0: 200 */
    unsigned patience_ms;     /* waiting of all reads together; 0: without end */
    /* Called at least every 0.1 s while a read waits; true ends the read. NULL: never. Any thread.
     */
    bool (*cancelled)(void *context);
    void *cancelled_context;
} stp_byte_source_params;

/* Counts so far. */
typedef struct stp_byte_source_stats {
    uint64_t requests;      /* sent, second tries included */
    uint64_t retries;       /* requests that followed a failed one */
    uint64_t bytes;         /* read from the file, or received as bodies of answers */
    uint64_t cached_bytes;  /* taken from the cache's folder instead */
    uint64_t cache_damaged; /* files in the cache that were wrong, and dropped */
    uint64_t damaged;       /* reads repeated because a checksum found them wrong */
} stp_byte_source_stats;

/* True for http://... and https://... */
bool stp_is_address(const char *path);

/* params may be NULL. Errors: NOT_FOUND, IO, OUT_OF_MEMORY, UNSUPPORTED (a server without ranges),
 * INVALID_ARGUMENT (no address), CANCELLED. */
stp_status stp_byte_source_open(stp_byte_source **out, const char *path,
                                const stp_byte_source_params *params, stp_error *err);
void stp_byte_source_close(stp_byte_source **source);

uint64_t stp_byte_source_size(const stp_byte_source *source);
/* The path, or the address without user, password and query: fit to be printed. */
const char *stp_byte_source_name(const stp_byte_source *source);
bool stp_byte_source_is_remote(const stp_byte_source *source);
/* Reads worth having in flight: 1 for a file. */
unsigned stp_byte_source_parallel(const stp_byte_source *source);

/* Reads exactly size bytes at offset. After a failure the content of data is undefined. Errors: IO,
 * CORRUPT (beyond the end), CANCELLED, those of open. */
stp_status stp_byte_source_read(stp_byte_source *source, uint64_t offset, void *data, size_t size,
                                stp_error *err);
/* The same, but past all caches: for bytes that a checksum found wrong. */
stp_status stp_byte_source_reread(stp_byte_source *source, uint64_t offset, void *data, size_t size,
                                  stp_error *err);

/* A read from a server ends with CANCELLED once its caller has not wanted it for so long. Most
 * answers come sooner; a request that is given up closes its connection. */
#define STP_SOURCE_UNWANTED_MS 200u

/* Whether the bytes of a read are still wanted. Called often, by the thread that reads. */
typedef struct stp_read_wish {
    bool (*is_wanted)(void *context);
    void *context;
} stp_read_wish;

/* A range of bytes, and where they go. */
typedef struct stp_byte_range {
    uint64_t offset;
    uint8_t *data;
    size_t size;
    size_t got; /* so many are there, from the first on */
} stp_byte_range;

/* At most so many at once. */
#define STP_SOURCE_RANGES 128u
/* Ranges that are read by one request have at most so many bytes, with what lies between. */
#define STP_SOURCE_REQUEST_BYTES (128u << 10)

/* How many ranges are worth reading at once although they lie far from each other. 1: each is a
 * request of its own, or no request. May grow or sink with what the server answers. */
unsigned stp_byte_source_ranges(const stp_byte_source *source);
/* Bytes between two ranges that are read rather than asking twice. */
uint32_t stp_byte_source_gap(const stp_byte_source *source);
/* Reads ranges, ordered by offset, by as few requests as the source takes. A range is there if its
 * `got` is its size afterwards, also if others failed; once a server failed, no more is asked for.
 * wish: NULL is as if it always held. Errors: as stp_byte_source_read, of the first that failed. */
stp_status stp_byte_source_read_ranges(stp_byte_source *source, stp_byte_range *ranges,
                                       size_t count, const stp_read_wish *wish, stp_error *err);

/* Makes all reads, present and future, end soon with CANCELLED, until resume. */
void stp_byte_source_cancel(stp_byte_source *source);
/* Lets reads begin again. Call it when the cancelled reads have ended. */
void stp_byte_source_resume(stp_byte_source *source);

void stp_byte_source_get_stats(stp_byte_source *source, stp_byte_source_stats *out);
/* Why the cache keeps nothing, as a sentence; false if all is well. */
bool stp_byte_source_note(stp_byte_source *source, stp_error *note);

#endif
