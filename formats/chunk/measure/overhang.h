/* How far merged discs lie outside the surface they stand for: the tangential error of a chunk's
 * patches.
 *
 * A rim that leaves the discs under it is no error where a neighbour's discs go on: only an open
 * border's overhang is (docs/algorithms.md, "Tangential error"). So each centre and rim point is
 * compared with level-0 discs of the chunk and what surrounds it. Over a disc it counts
 *   - how far it lies outside the disc, in the disc's plane,
 *   - what the disc brings from below, and
 *   - of its height over the disc what the perpendicular error e of its quarter, at level 3 of the
 *     patch, does not cover: of a height h that, with what the disc brings, exceeds the error the
 *     leg that is missing, sqrt(h^2 - e^2), and over discs that are not under its own merged disc
 *     what is aside from the merged disc's normal; no more than the height.
 * So e and what it counts are legs of a right angle that reach from the point to the disc, and seen
 * at the angle alpha the disc is within e sin(alpha) and that.
 *
 * A stored error must hold the least over all discs (SPEC.md). Measured is more, so that the point
 * is drawn near what is nearest to it in space, too: it is what the point counts over its nearest
 * disc, or over one no farther than that and the perpendicular error times the sine of the patch's
 * cone. The rule takes sin(alpha) for no less than that sine, wherever the eye is, so what is
 * nearer than such a disc is near enough in whatever direction it lies. Strips and triangles have
 * errors of their own (strip.h, triangles.h): they are measured as stored, and never refuted.
 * Threads: any, one chunk each. */
#ifndef STP_FORMATS_CHUNK_MEASURE_OVERHANG_H
#define STP_FORMATS_CHUNK_MEASURE_OVERHANG_H

#include "formats/chunk/measure/surroundings.h"

/* Errors of merged levels are not told apart below the patch's greatest level-0 radius over this:
 * it spares most of the search. */
#define STP_OVERHANG_PARTS 20.0

/* Tangential errors of a patch, world units: by level, and of levels 1 and 2, index level - 1, by
 * quarter. Never less than those of the finer level under it; at level 0 what its samples bring. */
typedef struct stp_overhang {
    double level[STP_LEVEL_COUNT];
    double quarter[2][STP_PATCH_QUARTERS];
} stp_overhang;

/* Measures all patches, out[patch_count], rounded up to what can be stored; a point whose nearest
 * disc cannot be told in bounded time goes by its nearest own. carry: by level-0
 * sample, or NULL for none. around: what reaches in from other chunks, with carries if the chunk
 * has them; NULL for nothing. The chunk has all levels and its patches' cones and perpendicular
 * errors. Errors: OUT_OF_MEMORY. */
stp_status stp_overhang_measure(stp_overhang *out, const stp_chunk *chunk, const stp_carry *carry,
                                const stp_surroundings *around, stp_error *err);

/* Sets *patch to the first whose stored tangential errors of merged levels are surely less than
 * what its points count without carries; STP_CHUNK_NONE if none is. Errors: OUT_OF_MEMORY. */
stp_status stp_overhang_check(uint32_t *patch, const stp_chunk *chunk,
                              const stp_surroundings *around, stp_error *err);

#endif
