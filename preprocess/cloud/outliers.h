/* Finds outliers: points, and small groups of points, far from everything else.
 *
 * "Far" depends on the local spacing, so a sparse part of a scan is no outlier just because another
 * part is dense. It is a ratio of neighbourhoods, as in LOF (Breunig et al. 2000).
 *
 *     s(p)     = spacing of p from its k-th neighbour
 *     local(p) = min(s(p), median of s(q) over p's neighbours q)
 *
 * For an outlier, local(p) is the spacing of the surface nearest to it. D is `distance`.
 * 1. A point p steps to its neighbour q if |p - q| <= D min(local(p), local(q)). A point from which
 *    steps reach more than k positions, its own included, is part of something: it is kept.
 * 2. A point p is also kept if it has a kept neighbour q with |p - q| <= D local(q), or if it is a
 *    neighbour of a kept q with |p - q| <= D s(q). This repeats until nothing changes. Where a
 *    dense part meets a sparse one, points at the edge of the sparse part have dense neighbours,
 *    and the sparse points behind have the edge as neighbours.
 * 3. All other points are outliers. But if rule 1 keeps nothing, there is no surface to be far
 *    from, and there are no outliers.
 *
 * Duplicates count as one position. Scattered points that are so many that they are each other's
 * neighbours are not found: by distance alone they are a sparse part of the scan. Threads: those of
 * the pool. The result depends neither on their number nor on the order of the input. */
#ifndef STP_PREPROCESS_CLOUD_OUTLIERS_H
#define STP_PREPROCESS_CLOUD_OUTLIERS_H

#include "base/progress.h"
#include "preprocess/cloud/cloud.h"

typedef enum stp_outlier_mode {
    STP_OUTLIERS_KEEP, /* no search */
    STP_OUTLIERS_MARK, /* stored with STP_SAMPLE_OUTLIER */
    STP_OUTLIERS_DROP  /* rejected: STP_REJECT_OUTLIER */
} stp_outlier_mode;

/* The default `distance`, in spacings, that makes an outlier. */
#define STP_OUTLIER_DISTANCE 3.0

/* Sets STP_MARK_OUTLIER on the outliers of a sorted cloud and *count to their number. Reads
 * positions only. Errors: OUT_OF_MEMORY, IO, INVALID_ARGUMENT (k), CANCELLED. */
stp_status stp_outliers_find(stp_cloud *cloud, unsigned k, double distance, stp_pool *pool,
                             const stp_progress *progress, uint64_t *count, stp_error *err);
/* Removes the marked points from the cloud and sorts the cloud as if they had never been there.
 * count: what stp_outliers_find found; not all points. *sources: the records of the removed points
 * that this process owned, ascending, *source_count of them; free with stp_spill_free of the
 * cloud's spill. Errors: those of the sort. */
stp_status stp_outliers_drop(stp_cloud *cloud, uint64_t count, stp_pool *pool, uint64_t **sources,
                             uint64_t *source_count, stp_error *err);

#endif
