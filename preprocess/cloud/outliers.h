/* Outliers: points, and small groups of points, far from everything else.
 *
 * Far is told by the spacing there, so that a sparse part of a scan is no outlier because another
 * part is dense: a ratio of neighbourhoods, as LOF's (Breunig et al. 2000). Of two spacings, a
 * point's own (from its k-th neighbour) and the median of its neighbours', the less is the local
 * one: an outlier has that of the surface it is nearest to.
 * 1. A point steps to those of its k neighbours that are within `distance` local spacings, by the
 *    less of both points'. Who gets to more than k positions so is part of something: kept.
 * 2. Kept, too, is who lies within `distance` local spacings of a kept one that is its neighbour,
 *    or `distance` of a kept one's own spacings that it is a neighbour of; and so on. Where a dense
 *    part meets a sparse one, points of the latter see the former, but those behind them see them.
 * 3. The rest are outliers; but if nothing is kept by 1, there is no surface to be far from.
 *
 * Duplicates count as one position. Does not find points scattered so many that they are each
 * other's neighbours: by distance alone they are a sparse part of the scan. Threads: those of the
 * pool; the result depends neither on their number nor on the order of the input. */
#ifndef STP_PREPROCESS_CLOUD_OUTLIERS_H
#define STP_PREPROCESS_CLOUD_OUTLIERS_H

#include "base/progress.h"
#include "preprocess/cloud/cloud.h"

typedef enum stp_outlier_mode {
    STP_OUTLIERS_KEEP, /* not looked for */
    STP_OUTLIERS_MARK, /* stored with STP_SAMPLE_OUTLIER */
    STP_OUTLIERS_DROP  /* rejected: STP_REJECT_OUTLIER */
} stp_outlier_mode;

/* Spacings from everything else that make an outlier, where the caller does not say. */
#define STP_OUTLIER_DISTANCE 3.0

/* Sets STP_MARK_OUTLIER of the outliers of a sorted cloud, *count of them. Reads positions alone.
 * Errors: OUT_OF_MEMORY, IO, INVALID_ARGUMENT (k), CANCELLED. */
stp_status stp_outliers_find(stp_cloud *cloud, unsigned k, double distance, stp_pool *pool,
                             const stp_progress *progress, uint32_t *count, stp_error *err);
/* Takes the marked points, `count` as found and not all, out of the cloud, and sorts it as if they
 * had never been there. *sources: theirs, going up; free with stp_spill_free of the cloud's.
 * Errors: those of the sort. */
stp_status stp_outliers_drop(stp_cloud *cloud, uint32_t count, stp_pool *pool, uint32_t **sources,
                             stp_error *err);

#endif
