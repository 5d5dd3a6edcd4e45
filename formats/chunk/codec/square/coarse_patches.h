/* Patches of squares whose errors, or cones' axes, are rounded: their cells count the steps.
 * Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_COARSE_PATCHES_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_COARSE_PATCHES_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/table/table.h"

/* A part says the shifts in so many bits. */
#define STP_PATCH_SHIFTS_BITS 6u

/* Errors of levels 3 to 1 are multiples of 2^errors; axes are on the grid of the shift `axes`. */
typedef struct stp_patch_shifts {
    unsigned errors, axes;
} stp_patch_shifts;

/* The greatest ones of a block. */
stp_patch_shifts stp_patch_shifts_find(const stp_chunk *block);
/* The bits that say them. */
uint32_t stp_patch_shifts_bits(const stp_patch_shifts *shifts);
/* Takes the lowest bits. Errors: CORRUPT (there is no such grid). */
stp_status stp_patch_shifts_take(uint32_t bits, stp_patch_shifts *out, stp_error *err);
/* Changes cells that stp_patches_encode made; changes them back. */
void stp_patch_shifts_encode(const stp_patch_shifts *shifts, const stp_chunk *block,
                             const stp_table *table);
void stp_patch_shifts_decode(const stp_patch_shifts *shifts, const stp_table *table);

#endif
