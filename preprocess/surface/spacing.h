/* Local spacings without outliers and noise.
 *
 * The distance to the k-th neighbour scatters by an eighth from point to point, and that of points
 * far from the surface is many times the spacing there. Mutual neighbours tell both: an outlier has
 * hardly any, a small group of them only each other, nearby; but a point of a sparse surface beside
 * a dense one has those of its own surface, so that its disc still reaches them. Each spacing is
 * held to what the mutual neighbours allow, then averaged with theirs. Duplicates share neighbours
 * and keep equal spacings. Threads: a unit each. */
#ifndef STP_PREPROCESS_SURFACE_SPACING_H
#define STP_PREPROCESS_SURFACE_SPACING_H

#include "preprocess/cloud/unit.h"

/* A spacing is held to this many times what the nearest third of the mutual neighbours give; on a
 * line of points, all spacings are 1.7 times that. */
#define STP_SPACING_EXCESS 2.0f

/* Where hardly any neighbour is mutual: so many medians of theirs. An outlier stays small, a point
 * between a sparse surface and a dense one still closes the seam. */
#define STP_SPACING_MEDIANS 3.0f

/* Replaces the spacings of all points that have two rings around them; 0 (no distinct neighbour)
 * stays. Errors: OUT_OF_MEMORY. */
stp_status stp_spacing_smooth(stp_unit *unit, stp_error *err);

#endif
