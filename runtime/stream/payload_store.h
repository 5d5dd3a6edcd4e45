/* Payloads of chunks as they stand in the file, kept in memory: what was read once need not be read
 * again while it is here. One region of fixed size, so that no use of it grows or fragments the
 * heap.
 *
 * Keeps a prefix of a payload at least as long as asked for; forgets what was not used lately. What
 * is pinned stays. Threads: one at a time (the stream's mutex). */
#ifndef STP_RUNTIME_STREAM_PAYLOAD_STORE_H
#define STP_RUNTIME_STREAM_PAYLOAD_STORE_H

#include "base/error.h"
#include "runtime/stream/range_pool.h"

/* A region is cut into pieces of so many bytes. */
#define STP_PAYLOAD_UNIT_BYTES 4096u

typedef struct stp_payload {
    uint32_t chunk;  /* STP_CHUNK_NONE: forgotten when unpinned */
    stp_range range; /* units of the region */
    uint32_t bytes;  /* of the payload that are there */
    unsigned pins;
    uint64_t last_used;
} stp_payload;

typedef struct stp_payload_store {
    uint8_t *region;
    uint64_t region_bytes;
    stp_range_pool ranges;
    stp_payload *payloads;
    size_t count, capacity;
    uint64_t clock;
} stp_payload_store;

/* Errors: OUT_OF_MEMORY. */
stp_status stp_payload_store_create(stp_payload_store *out, uint64_t bytes, stp_error *err);
void stp_payload_store_destroy(stp_payload_store *store);

/* The memory of a pinned payload. */
uint8_t *stp_payload_memory(const stp_payload_store *store, stp_range range);

/* If the first `bytes` of a chunk's payload are here, pins them and gives their place. */
bool stp_payload_store_find(stp_payload_store *store, uint32_t chunk, uint32_t bytes,
                            stp_range *out);
/* Room for the first `bytes` of a chunk's payload, pinned; what is known of them already is copied
 * there: *known bytes. False where everything else is pinned. Errors go to *status. */
bool stp_payload_store_make(stp_payload_store *store, uint32_t chunk, uint32_t bytes,
                            stp_range *out, uint32_t *known, stp_status *status, stp_error *err);
/* All bytes of a place that was made are there now. */
void stp_payload_store_filled(stp_payload_store *store, stp_range range, uint32_t bytes);
void stp_payload_store_unpin(stp_payload_store *store, stp_range range);
/* Forgets a pinned payload: it was damaged, or could not be read. Unpins it. */
void stp_payload_store_discard(stp_payload_store *store, stp_range range);

#endif
