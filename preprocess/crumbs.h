/* Crumbs: pieces too small to be sheets, which noise and sharp edges leave between the sheets. */
#ifndef STP_PREPROCESS_CRUMBS_H
#define STP_PREPROCESS_CRUMBS_H

#include "preprocess/forest.h"
#include "preprocess/neighbours.h"

/* Most points of a crumb. */
#define STP_CRUMB_POINTS 64u

typedef struct stp_crumbs {
    uint32_t *points; /* all that are on crumbs, in the cloud's order */
    uint32_t *pieces; /* of each, its crumb: numbered from 0 */
    uint32_t point_count, piece_count;
    stp_spill *spill; /* where they lie */
} stp_crumbs;

/* Finds the forest's crumbs and sets every point's sheet: the root of its piece, or, on a crumb, of
 * the sheet nearby whose planes it lies nearest to. Errors: OUT_OF_MEMORY. */
stp_status stp_crumbs_find(stp_crumbs *out, stp_cloud *cloud, const stp_neighbours *neighbours,
                           stp_forest *forest, stp_error *err);
/* Turns each crumb of oriented points with which its oriented neighbours disagree, by the sum of
 * the logarithms of the odds that each relation is right. Errors: OUT_OF_MEMORY. */
stp_status stp_crumbs_settle(const stp_crumbs *crumbs, stp_cloud *cloud,
                             const stp_neighbours *neighbours, stp_pool *pool, stp_error *err);
void stp_crumbs_clear(stp_crumbs *crumbs);

#endif
