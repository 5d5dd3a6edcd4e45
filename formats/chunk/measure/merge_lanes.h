/* Extents of discs over the plane of the merged disc that replaces them, and which of them is
 * nearest to each of its points: several discs, or several points, at a time.
 *
 * Lengths and positions are in any unit. Extents are as exact as doubles. Distances are as exact as
 * floats: if you need an exact number, compute it for the chosen disc. Threads: any. */
#ifndef STP_FORMATS_CHUNK_MEASURE_MERGE_LANES_H
#define STP_FORMATS_CHUNK_MEASURE_MERGE_LANES_H

#include "base/vec.h"

#include <stdbool.h>
#include <stdint.h>

/* Discs under a merged disc, at most. */
#define STP_MERGED_MOST 64
/* How many are taken at a time, a power of two. */
#define STP_MERGED_STEP 4u
/* The points of a merged disc: its centre, then 16 of its rim. */
#define STP_MERGED_POINTS 17

/* The discs under a merged disc, 1 or more. Copies of one of them fill up the last step. */
typedef struct stp_merge_lanes {
    unsigned count;
    double centre[3][STP_MERGED_MOST]; /* from the merged disc's, by axis */
    double normal[3][STP_MERGED_MOST]; /* zero: a ball */
    double radius[STP_MERGED_MOST];
    /* of what a disc stands for: height along its normal, extent in its plane and in space */
    double low[STP_MERGED_MOST], high[STP_MERGED_MOST];
    double reach[STP_MERGED_MOST], bound[STP_MERGED_MOST];
} stp_merge_lanes;

/* How far all that the discs stand for reaches from the centre of the merged disc: least and
 * greatest height along its normal, extent in its plane and in space. cosine: of the widest angle
 * between its normal and the normal of a disc. */
typedef struct stp_merge_extent {
    double low, high, reach, bound, cosine;
} stp_merge_extent;

/* normal: of the merged disc, zero if it has none. */
stp_merge_extent stp_merge_lanes_extent(const stp_merge_lanes *discs, stp_dvec3 normal);

/* Least and greatest height alone, and how far any point of the merged disc may lie off the plane
 * of any of the discs. */
typedef struct stp_merge_heights {
    double low, high, off;
} stp_merge_heights;

/* normal, radius: of the merged disc. */
stp_merge_heights stp_merge_lanes_heights(const stp_merge_lanes *discs, stp_dvec3 normal,
                                          double radius);

/* The points of a merged disc. */
typedef struct stp_merged_points {
    double at[3][STP_MERGED_POINTS];     /* by axis */
    uint32_t nearest[STP_MERGED_POINTS]; /* which disc; the first one of those that are as near */
    float height[STP_MERGED_POINTS]; /* over its plane, without sign, by the merged disc's radius */
} stp_merged_points;

/* Finds the nearest discs. axes: the two that span the merged disc's plane. NULL: it has no rim;
 * only its centre is told. If the radius is 0, heights are not divided by it. */
void stp_merge_lanes_nearest(const stp_merge_lanes *discs, stp_dvec3 centre,
                             const stp_dvec3 axes[2], double radius, stp_merged_points *out);

#endif
