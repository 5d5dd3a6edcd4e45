/* Boxes over runs of eight consecutive points, and boxes over eight boxes below, up to one root:
 * finds the runs near a box, eight tests at a time.
 *
 * Boxes are floats: what is near is found, and now and then what is a little farther. Threads: any
 * number may search a finished tree. */
#ifndef STP_PREPROCESS_CLOUD_RUN_TREE_H
#define STP_PREPROCESS_CLOUD_RUN_TREE_H

#include "base/error.h"

#include <stdint.h>

/* Points of a run, and boxes below one box. */
#define STP_RUN_POINTS 8u
/* Enough for 2^32 points. */
#define STP_RUN_TIERS 11
/* Most runs that a search finds. */
#define STP_RUNS_NEAR 64u

/* The boxes of what lies below a box. Lanes without anything below are infinitely far. */
typedef struct stp_run_node {
    float low[3][STP_RUN_POINTS], high[3][STP_RUN_POINTS];
} stp_run_node;

typedef struct stp_run_tree {
    stp_run_node *nodes;               /* tier by tier, those over runs first */
    uint32_t begin[STP_RUN_TIERS + 1]; /* where each tier begins; then the end of the last tier */
    unsigned tier_count;               /* 0: no points */
} stp_run_tree;

/* Builds the tree over count points, each axis by itself. Errors: OUT_OF_MEMORY. */
stp_status stp_run_tree_create(stp_run_tree *out, const float *const axes[3], uint32_t count,
                               stp_error *err);
void stp_run_tree_clear(stp_run_tree *tree);

/* Sets runs[] to the runs that come within `reach` of a box, ascending; run r has the points from r
 * STP_RUN_POINTS on. Returns how many, or STP_RUNS_NEAR + 1 if there are more than STP_RUNS_NEAR.
 */
unsigned stp_run_tree_near(const stp_run_tree *tree, const float low[3], const float high[3],
                           float reach, uint32_t runs[STP_RUNS_NEAR]);

#endif
