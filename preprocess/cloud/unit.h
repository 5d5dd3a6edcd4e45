/* A unit of local work: a run of cells, and rings of points around it.
 *
 * Results for the unit's own points depend on the rings. Ring 1: the neighbours of own points that
 * are not own points. Ring 2: the neighbours of ring 1 that are new; and so on.
 *
 *     own points | ring 1 | ring 2 | ...        numbered from 0 in this order
 *
 * Points are copies; own ones are in the cloud's order. A point's result is the same in every unit
 * that has the point, so results do not depend on how cells form units. Threads: units run side by
 * side. They read only those parts of the cloud that no unit writes. */
#ifndef STP_PREPROCESS_CLOUD_UNIT_H
#define STP_PREPROCESS_CLOUD_UNIT_H

#include "preprocess/cloud/neighbours.h"

/* Rings: 1 for planes, 2 for growing them twice, 1 for averaging normals over neighbours, 1 for
 * sheets: 5. Spacings need 2. */
#define STP_UNIT_RINGS 5u

typedef struct stp_unit {
    const stp_cloud *whole;    /* borrowed */
    stp_cloud cloud;           /* the copies; only points, count and capacity are set */
    stp_neighbours neighbours; /* by number, of all points without those of the last ring */
    uint64_t *places;          /* by number: its place in the whole cloud */
    unsigned ring_count;
    uint32_t ring_end[STP_UNIT_RINGS + 1]; /* where the own points end, then each ring */
    uint8_t *wide;    /* by own point: STP_MARK_WIDE, STP_MARK_WIDEST or 0, set by
                         stp_normals_estimate; NULL before */
    float *roundness; /* by point that has a ring around it: of its neighbourhood (moments.h); set
                         likewise */
} stp_unit;

/* Builds the unit of cells [first, end) of a sorted cloud with ring_count rings. Every point's
 * spacing is that of stp_neighbours_find. If the cloud misses points (cloud_blocks.h), the unit is
 * to be cleared and made again when they are here. Errors: OUT_OF_MEMORY, INVALID_ARGUMENT (k). */
stp_status stp_unit_create(stp_unit *out, const stp_cloud *whole, uint32_t first, uint32_t end,
                           unsigned k, unsigned ring_count, stp_error *err);
void stp_unit_clear(stp_unit *unit);

/* How many points, from number 0, have at least `rings` complete rings around them. */
static inline uint32_t stp_unit_inner(const stp_unit *unit, unsigned rings)
{
    return unit->ring_end[rings < unit->ring_count ? unit->ring_count - rings : 0];
}

#endif
