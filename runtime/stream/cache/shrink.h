/* Gives back the samples of a resident block that are finer than what its patches are drawn at:
 * what is kept is copied to the upload ring and back to a smaller place. Nothing is decoded again.
 * Threads: the render thread. */
#ifndef STP_RUNTIME_STREAM_CACHE_SHRINK_H
#define STP_RUNTIME_STREAM_CACHE_SHRINK_H

#include "runtime/stream/cache/block_cache.h"
#include "runtime/stream/upload_ring.h"

/* The texels that a block takes if its patches keep no levels finer than those in the list. It may
 * be some more than what they need. */
uint32_t stp_shrink_texels(const stp_resident *resident, const uint8_t *finest);
/* Keeps no levels finer than those in the list, and moves the block to the first place that is
 * large enough. False if the ring has no room. Errors go to *status: OUT_OF_MEMORY. */
bool stp_shrink(stp_object_texture *texture, stp_upload_ring *ring, stp_resident *resident,
                const uint8_t *finest, stp_status *status, stp_error *err);

#endif
