/* Finds the one flipped bit of checked bytes by their checksum.
 *
 * 64 bits of checksum tell what the bytes were: among a few million possible flips a second one
 * fits with a chance of 1 in 10^12. Time grows with the square of the size. Changes nothing.
 * Threads: one call at a time per pool, which it uses. */
#ifndef STP_FORMATS_CHUNK_REPAIR_MEND_BIT_H
#define STP_FORMATS_CHUNK_REPAIR_MEND_BIT_H

#include "base/pool.h"
#include "base/progress.h"

#include <stddef.h>
#include <stdint.h>

#define STP_NO_BIT SIZE_MAX
/* Larger regions are not searched: this size takes a minute or two on two cores. */
#define STP_MEND_BYTES_LIMIT (1u << 20)

/* Sets *bit to the bit (8 * byte + bit) whose flip gives the `size` bytes the checksum `hash` in
 * the bits of `mask`; from 8 * size on it is a bit of `hash` itself. Sets STP_NO_BIT if there is
 * none. More than a KiB is not searched if a run of equal bytes is as long as half a disk's sector:
 * then more is lost than a bit. Errors: OUT_OF_MEMORY, CANCELLED. */
stp_status stp_mend_bit(const uint8_t *bytes, size_t size, uint64_t hash, uint64_t mask,
                        stp_pool *pool, const stp_progress *progress, size_t *bit, stp_error *err);

#endif
