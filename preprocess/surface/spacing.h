/* Local spacings without outliers and noise.
 *
 * The distance to the k-th neighbour scatters by an eighth from point to point. For a point far
 * from the surface, it is many times the surface's spacing. Mutual neighbours show both:
 * - An outlier has hardly any mutual neighbours.
 * - Points of a small group have only each other, nearby.
 * - A point of a sparse surface beside a dense one has those of its own surface, so its disc still
 *   reaches them.
 *
 * Each spacing is limited by the mutual neighbours, then averaged with their spacings. Duplicates
 * share neighbours and keep equal spacings. Threads: a unit each. */
#ifndef STP_PREPROCESS_SURFACE_SPACING_H
#define STP_PREPROCESS_SURFACE_SPACING_H

#include "preprocess/cloud/unit.h"

/* A spacing is at most this many times what the nearest third of the mutual neighbours gives. On a
 * line of points, every spacing is 1.7 times that. */
#define STP_SPACING_EXCESS 2.0f

/* If hardly any neighbour is mutual, the limit is this many medians of the neighbours' spacings. An
 * outlier stays small; a point between a sparse surface and a dense one still closes the seam. */
#define STP_SPACING_MEDIANS 3.0f

/* Replaces the spacings of all points with two rings around them. 0 (no distinct neighbour) stays
 * 0. Errors: OUT_OF_MEMORY. */
stp_status stp_spacing_smooth(stp_unit *unit, stp_error *err);

#endif
