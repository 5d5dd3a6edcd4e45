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

#include "preprocess/surface/neighbour_columns.h"

/* A spacing is at most this many times what the nearest third of the mutual neighbours gives. On a
 * line of points, every spacing is 1.7 times that. */
#define STP_SPACING_EXCESS 2.0f

/* If hardly any neighbour is mutual, the limit is this many medians of the neighbours' spacings. An
 * outlier stays small; a point between a sparse surface and a dense one still closes the seam. */
#define STP_SPACING_MEDIANS 3.0f

/* What smoothing needs of points that have a ring around them. */
typedef struct stp_spacings {
    float *inverse;   /* by point: of its limited spacing; 0 if that is 0 */
    uint64_t *mutual; /* by point: one bit for each neighbour that has the point as its neighbour */
} stp_spacings;

/* Makes room for `count` points. Errors: OUT_OF_MEMORY. */
stp_status stp_spacings_create(stp_spacings *out, uint32_t count, stp_error *err);
void stp_spacings_clear(stp_spacings *spacings);

/* Limits the spacings of the columns' first `count` points. */
void stp_spacings_limit(stp_spacings *spacings, const stp_unit *unit,
                        const stp_neighbour_columns *columns, uint32_t count);
/* Replaces the spacings of all points with two rings around them. 0 (no distinct neighbour) stays
 * 0. The points with one ring around them must be limited. */
void stp_spacings_smooth(const stp_spacings *spacings, stp_unit *unit);

#endif
