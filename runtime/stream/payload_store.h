/* Keeps payloads of blocks in memory, as they are in the file, so that they need not be read again.
 * The memory is one region of fixed size, so the store never grows or fragments the heap.
 *
 * Keeps a prefix of each payload, at least as long as was asked for. Forgets the payloads that were
 * used least lately, but no pinned ones. Threads: one at a time (the stream's mutex). */
#ifndef STP_RUNTIME_STREAM_PAYLOAD_STORE_H
#define STP_RUNTIME_STREAM_PAYLOAD_STORE_H

#include "base/error.h"
#include "runtime/stream/cache/range_pool.h"

/* The region is cut into units of so many bytes. */
#define STP_PAYLOAD_UNIT_BYTES 512u

typedef struct stp_payload {
    stp_range range; /* units of the region; none: there is no payload */
    uint32_t bytes;  /* of the payload that are in memory */
    bool pinned;
    uint32_t before, after; /* in the order of use */
} stp_payload;

typedef struct stp_payload_store {
    uint8_t *region;
    uint64_t region_bytes;
    stp_range_pool ranges;
    stp_payload *payloads; /* by block; the last one closes the ring of those in use */
    uint32_t block_count;
} stp_payload_store;

/* For blocks 0 to block_count - 1. Errors: OUT_OF_MEMORY. */
stp_status stp_payload_store_create(stp_payload_store *out, uint64_t bytes, uint32_t block_count,
                                    stp_error *err);
void stp_payload_store_destroy(stp_payload_store *store);

/* The memory of a pinned payload. */
uint8_t *stp_payload_memory(const stp_payload_store *store, stp_range range);

/* If the first `bytes` of a block's payload are in memory, pins them and returns their place. The
 * payload must not be pinned yet. */
bool stp_payload_store_find(stp_payload_store *store, uint32_t block, uint32_t bytes,
                            stp_range *out);
/* How many bytes of a block's payload are in memory. */
uint32_t stp_payload_store_known(const stp_payload_store *store, uint32_t block);
/* Makes room for the first `bytes` of a block's payload, and pins it. Copies the bytes that are
 * already in memory there; *known is their number. The payload must not be pinned yet. False if
 * everything else is pinned. Errors go to *status. */
bool stp_payload_store_make(stp_payload_store *store, uint32_t block, uint32_t bytes,
                            stp_range *out, uint32_t *known, stp_status *status, stp_error *err);
/* Says that the first `bytes` of a pinned payload are there now. */
void stp_payload_store_filled(stp_payload_store *store, uint32_t block, uint32_t bytes);
void stp_payload_store_unpin(stp_payload_store *store, uint32_t block);
/* Forgets a pinned payload that is damaged or could not be read. */
void stp_payload_store_discard(stp_payload_store *store, uint32_t block);

#endif
