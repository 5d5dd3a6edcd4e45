/* How far merged discs lie outside the surface they stand for: the tangential error of a chunk's
 * patches.
 *
 * A rim that leaves the discs under it is no error where a neighbour's discs go on: only an open
 * border's overhang is (ALGORITHMS "Tangential error"). So each centre and rim point is compared
 * with its nearest level-0 disc in the chunk and what surrounds it. Threads: any, one chunk each.
 */
#ifndef STP_FORMATS_CHUNK_OVERHANG_H
#define STP_FORMATS_CHUNK_OVERHANG_H

#include "formats/chunk/surroundings.h"

/* Errors of merged levels are not told apart below the patch's greatest level-0 radius over this:
 * it spares most of the search. */
#define STP_OVERHANG_PARTS 12.0

/* Tangential errors of a patch, world units: by level, and of levels 1 and 2, index level - 1, by
 * quarter. Never less than those of the finer level under it; at level 0 what its samples bring. */
typedef struct stp_overhang {
    double level[STP_LEVEL_COUNT];
    double quarter[2][STP_PATCH_QUARTERS];
} stp_overhang;

/* What a point counts whose nearest disc cannot be told in bounded time. */
typedef enum stp_overhang_doubt {
    STP_OVERHANG_BOUND, /* its overhang over its own discs: for who stores what it finds */
    STP_OVERHANG_LEAST  /* nothing: for who would refute what is stored */
} stp_overhang_doubt;

/* Measures all patches, out[patch_count]. The overhang of a point is the lesser of
 *   - the overhang over the nearest disc under its own merged disc, and
 *   - that over the nearest disc of all, and of the height there what the perpendicular error of
 *     the quarter, at level 3 of the patch, which counts along the merged disc's normal, does not
 *     cover.
 * carry: by level-0 sample, or NULL for none. around: what reaches in from other chunks, with
 * carries if the chunk has them; NULL for nothing. The chunk has all levels and its patches'
 * perpendicular errors. Errors: OUT_OF_MEMORY. */
stp_status stp_overhang_measure(stp_overhang *out, const stp_chunk *chunk, const stp_carry *carry,
                                const stp_surroundings *around, stp_overhang_doubt doubt,
                                stp_error *err);

#endif
