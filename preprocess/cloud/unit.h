/* A unit of local work: a run of cells, and rings of points around it that what is found of its own
 * points depends on.
 *
 * Ring 1 are the neighbours of own points that are not own points themselves, ring 2 the neighbours
 * of those, and so on. Points are copies, numbered from 0: own ones in the cloud's order, then ring
 * by ring. What is found of a point is the same in every unit it is in, so results do not depend on
 * how cells are put together. Threads: units side by side; they read of the cloud what no unit
 * writes. */
#ifndef STP_PREPROCESS_CLOUD_UNIT_H
#define STP_PREPROCESS_CLOUD_UNIT_H

#include "preprocess/cloud/neighbours.h"

/* Planes need one ring, each of the two times that they grow another, normals averaged over
 * neighbours one more, sheets another. Spacings need two. */
#define STP_UNIT_RINGS 5u

typedef struct stp_unit {
    const stp_cloud *whole;    /* borrowed */
    stp_cloud cloud;           /* the copies; nothing of it but points, count and capacity */
    stp_neighbours neighbours; /* by number, of all points but those of the last ring */
    uint32_t *places;          /* in the whole cloud, by number */
    unsigned ring_count;
    uint32_t ring_end[STP_UNIT_RINGS + 1]; /* own points first, then by ring */
    uint8_t *wide;                         /* of own points: STP_MARK_WIDE, STP_MARK_WIDEST or 0;
                                              as stp_normals_estimate says, else NULL */
} stp_unit;

/* Takes cells [first, end) of a sorted cloud and so many rings, with everyone's spacing as
 * stp_neighbours_find gives it. Errors: OUT_OF_MEMORY, INVALID_ARGUMENT (k). */
stp_status stp_unit_create(stp_unit *out, const stp_cloud *whole, uint32_t first, uint32_t end,
                           unsigned k, unsigned ring_count, stp_error *err);
void stp_unit_clear(stp_unit *unit);

/* Points of which all is known that needs so many rings around them. */
static inline uint32_t stp_unit_inner(const stp_unit *unit, unsigned rings)
{
    return unit->ring_end[rings < unit->ring_count ? unit->ring_count - rings : 0];
}

#endif
