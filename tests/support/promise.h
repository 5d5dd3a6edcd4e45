/* Measures the error promise from geometry, never from stored errors: how far, on the screen, the
 * centre and 16 rim points of a drawn disc lie from the nearest points of the level-0 discs.
 *
 * Nearest means nearest in space, among all level-0 discs of the model, of any patch. A level-0
 * disc without normal is treated as a ball; a drawn disc without normal faces the eye. World axes
 * and units, double. Threads: any, once the index is made. */
#ifndef STP_TESTS_SUPPORT_PROMISE_H
#define STP_TESTS_SUPPORT_PROMISE_H

#include "base/error.h"
#include "base/vec.h"
#include "formats/chunk/chunk_file.h"
#include "runtime/camera/camera.h"

#include <stdbool.h>
#include <stddef.h>

#define PROMISE_RIM_POINTS 16
#define PROMISE_POINTS (PROMISE_RIM_POINTS + 1)

typedef struct promise_disc {
    stp_dvec3 centre;
    stp_dvec3 normal; /* unit; zero if unknown */
    double radius;
} promise_disc;

/* Points of a drawn disc, the centre first, and the points nearest to them. */
typedef struct promise_pairs {
    stp_dvec3 drawn[PROMISE_POINTS], nearest[PROMISE_POINTS];
    size_t disc[PROMISE_POINTS]; /* which disc the nearest point is on */
} promise_pairs;

typedef struct promise_index promise_index;

/* Copies the discs into a grid. Errors: OUT_OF_MEMORY, EMPTY (no disc). */
stp_status promise_index_create(promise_index **out, const promise_disc *discs, size_t count,
                                stp_error *err);
void promise_index_destroy(promise_index **index);

/* The nearest point on one disc; exact. */
stp_dvec3 promise_nearest_on(const promise_disc *disc, stp_dvec3 x);
/* The nearest point on all discs; *disc (may be NULL) is the disc's index. */
stp_dvec3 promise_nearest(const promise_index *index, stp_dvec3 x, size_t *disc);

/* Finds the pairs of a drawn disc. eye matters only if the disc has no normal. */
void promise_trace(const promise_index *index, const promise_disc *drawn, stp_dvec3 eye,
                   promise_pairs *out);

/* The distance in pixels between the projections of two points; negative if one of them is not in
 * front of the near plane. */
double promise_displacement_px(const stp_view *view, stp_dvec3 a, stp_dvec3 b);

/* Sums over what a view showed; starts zeroed. */
typedef struct promise_tally {
    size_t discs, points, behind; /* behind: points without a projection */
    size_t broken;                /* points farther than the threshold */
    double max_px, sum_px;
    size_t histogram[64]; /* of displacement / threshold, in 1/32 */
} promise_tally;

/* Adds the points of one drawn disc. */
void promise_add(promise_tally *tally, const promise_pairs *pairs, const stp_view *view,
                 double threshold_px);
/* Returns the displacement, in thresholds, that this share of the points does not exceed (rounded
 * up). */
double promise_quantile(const promise_tally *tally, double share);

/* The disc of a decoded sample, in the world. */
promise_disc promise_disc_from_sample(const stp_chunk_entry *entry, const stp_patch *patch,
                                      const stp_sample *sample);
/* Loads level 0 of all leaf chunks in the order of the chunks; free it with free(). Errors: those
 * of reading. */
stp_status promise_load_leaves(stp_chunk_file *file, promise_disc **discs, size_t *count,
                               stp_error *err);

#endif
