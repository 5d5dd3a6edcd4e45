/* For each place near a surface of discs one disc that lies well under it.
 *
 * Space is cut into cells somewhat wider than a disc's radius; a cell names, of the discs whose
 * centres lie in it or just over or under it, the one nearest to its middle. Cells are hashed, and
 * two may share a slot: a hint is to be checked. Threads: any may ask at once. */
#ifndef STP_FORMATS_CHUNK_MEASURE_DISC_HINTS_H
#define STP_FORMATS_CHUNK_MEASURE_DISC_HINTS_H

#include "formats/chunk/measure/disc_lanes.h"

/* Discs a hint can name. */
#define STP_DISC_HINTS_BITS 18u
#define STP_DISC_HINTS_LIMIT (1u << STP_DISC_HINTS_BITS)

typedef struct stp_disc_hints {
    const stp_lane_disc *discs; /* borrowed */
    uint32_t *slots, mask;
    float scale; /* cells a unit of length */
} stp_disc_hints;

/* count: at most STP_DISC_HINTS_LIMIT. radius: of a usual disc, > 0, and no less than a millionth
 * of the greatest coordinate. Errors: OUT_OF_MEMORY. */
stp_status stp_disc_hints_create(stp_disc_hints *out, const stp_lane_disc *discs, uint32_t count,
                                 double radius, stp_error *err);
void stp_disc_hints_clear(stp_disc_hints *hints);

/* Gives each point of the lanes a disc. */
void stp_disc_hints_pair(const stp_disc_hints *hints, stp_paired_lanes *lanes);

/* Discs of the eight cells about the cell's corner that is nearest to a point. */
void stp_disc_hints_about(const stp_disc_hints *hints, const float point[3],
                          uint32_t disc[STP_LANE_STEP]);

#endif
