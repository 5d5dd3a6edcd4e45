/* Hints: for each place near a surface of discs, one disc that lies close under it.
 *
 * Space is cut into cells somewhat wider than a disc's radius. A cell names one disc: of the discs
 * whose centres lie in the cell or just over or under it, the one nearest to its middle. Cells are
 * hashed, and two may share a slot, so a hint must be checked. Threads: any may ask at once. */
#ifndef STP_FORMATS_CHUNK_MEASURE_DISC_HINTS_H
#define STP_FORMATS_CHUNK_MEASURE_DISC_HINTS_H

#include "formats/chunk/measure/disc_lanes.h"

/* Most discs that hints can name. */
#define STP_DISC_HINTS_BITS 18u
#define STP_DISC_HINTS_LIMIT (1u << STP_DISC_HINTS_BITS)

typedef struct stp_disc_hints {
    const stp_lane_disc *discs; /* borrowed */
    uint32_t *slots, mask;
    float scale; /* cells a unit of length */
} stp_disc_hints;

/* count: at most STP_DISC_HINTS_LIMIT. radius: of a typical disc, > 0 and at least a millionth of
 * the greatest coordinate. Errors: OUT_OF_MEMORY. */
stp_status stp_disc_hints_create(stp_disc_hints *out, const stp_lane_disc *discs, uint32_t count,
                                 double radius, stp_error *err);
void stp_disc_hints_clear(stp_disc_hints *hints);

/* Pairs each point of the lanes with the disc that its cell names. */
void stp_disc_hints_pair(const stp_disc_hints *hints, stp_paired_lanes *lanes);

/* Names the discs of the eight cells that meet at the cell corner nearest to a point. */
void stp_disc_hints_about(const stp_disc_hints *hints, const float point[3],
                          uint32_t disc[STP_LANE_STEP]);

#endif
