/* The memory through which blocks reach the GPU: a buffer that stays mapped, or is of our own
 * memory, so that decoders write into it while frames are drawn. A piece becomes free again when
 * the fence behind its copy has passed. Threads: the render thread; any thread may write the memory
 * of a piece that was taken. */
#ifndef STP_RUNTIME_STREAM_UPLOAD_RING_H
#define STP_RUNTIME_STREAM_UPLOAD_RING_H

#include "base/error.h"
#include "runtime/gl/lazy_buffer.h"
#include "runtime/stream/cache/range_pool.h"

#include <epoxy/gl.h>

#define STP_UPLOAD_UNIT_BYTES 256u
/* Pending fences, one for each frame that copied something. At the limit, taking a piece waits for
 * the oldest fence. */
#define STP_UPLOAD_FENCES_LIMIT 8
/* Pieces that were copied and are not free yet. */
#define STP_UPLOAD_COPIED_LIMIT 1024

typedef struct stp_upload_ring {
    stp_lazy_buffer buffer;
    uint8_t *memory;
    stp_range_pool ranges; /* units */
    stp_range copied[STP_UPLOAD_COPIED_LIMIT];
    size_t copied_count;
    struct {
        GLsync sync;
        size_t count; /* of pieces in `copied`, after those of earlier fences */
    } fences[STP_UPLOAD_FENCES_LIMIT];
    size_t fence_count, fenced_count; /* fenced_count: pieces that have a fence */
} stp_upload_ring;

/* software: see stp_lazy_buffer_create. Errors: GL (no memory). */
stp_status stp_upload_ring_create(stp_upload_ring *out, uint64_t bytes, bool software,
                                  stp_error *err);
void stp_upload_ring_destroy(stp_upload_ring *ring);

/* False if no piece is free. Errors go to *status: OUT_OF_MEMORY. */
bool stp_upload_ring_take(stp_upload_ring *ring, uint64_t bytes, stp_range *out, stp_status *status,
                          stp_error *err);
/* Where a piece begins: in memory, and in the buffer. */
uint8_t *stp_upload_ring_memory(const stp_upload_ring *ring, stp_range piece);
uint64_t stp_upload_ring_offset(stp_range piece);
/* Gives back a piece that nothing was copied from. */
void stp_upload_ring_give(stp_upload_ring *ring, stp_range piece);
/* Issues a copy of bytes that begin at `from` in the ring to `to` in a buffer, whose pages there
 * get memory. */
void stp_upload_ring_copy(const stp_upload_ring *ring, stp_lazy_buffer *buffer, uint64_t from,
                          uint64_t to, uint64_t bytes);
/* Marks a piece whose copy was just issued. The piece is free when the next fence has passed. */
void stp_upload_ring_copied(stp_upload_ring *ring, stp_range piece);
/* Puts a fence behind the copies since the last one. Frees the pieces of passed fences. */
void stp_upload_ring_fence(stp_upload_ring *ring);
/* Waits for the oldest fence; false if there is none. */
bool stp_upload_ring_wait(stp_upload_ring *ring);
/* Whether one more piece may be copied before the next fence. */
bool stp_upload_ring_may_copy(const stp_upload_ring *ring);

#endif
