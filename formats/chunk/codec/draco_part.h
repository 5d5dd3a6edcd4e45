/* Parts of codec 1: samples as small numbers in tables, which are coded by odds (tight parts) or by
 * Draco. SPEC.md, "Payload" and "Blocks". The contract is that of part.h. */
#ifndef STP_FORMATS_CHUNK_CODEC_DRACO_PART_H
#define STP_FORMATS_CHUNK_CODEC_DRACO_PART_H

#include "formats/chunk/codec/shares.h"
#include "formats/chunk/codec/square/coarse_patches.h"
#include "formats/chunk/codec/square/placed.h"

stp_status stp_draco_part_encode(const stp_chunk *chunk, int segment, stp_bytes *out,
                                 stp_error *err);
/* shares: NULL, or counts the bytes of each attribute. */
stp_status stp_draco_part_decode(const uint8_t *bytes, size_t size, int segment,
                                 uint32_t child_count, stp_chunk *chunk, stp_shares *shares,
                                 stp_error *err);

/* For both: */

/* A tight part of squares, no other one, begins with this number, plus 1 if they are tilted, plus 2
 * if patches are placed by them, plus the shifts of their errors and axes, plus STOPS if slopes
 * stop at jumps. */
#define STP_TIGHT_SQUARES (UINT32_C(1) << 30)
#define STP_TIGHT_TILTED 1u
#define STP_TIGHT_PLACED 2u
#define STP_TIGHT_SHIFTS_AT 2u
#define STP_TIGHT_STOPS (UINT32_C(1) << (STP_TIGHT_SHIFTS_AT + STP_PATCH_SHIFTS_BITS))
#define STP_TIGHT_BITS (STP_TIGHT_SHIFTS_AT + STP_PATCH_SHIFTS_BITS + 1u)
#define STP_TIGHT_SQUARES_BYTES 4u

static inline void stp_set_placed(bool placed, stp_table *patches)
{
    patches->placed = placed;
    if (placed)
        patches->tight_first = stp_placed_first;
}

#endif
