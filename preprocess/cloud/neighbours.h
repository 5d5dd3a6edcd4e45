/* The k nearest distinct positions of points, exactly.
 *
 * 1. Boxes over runs of a locale's points give candidates, in one search for a few consecutive
 *    points (run_tree.h). Floats say which candidates may be near enough to a point, doubles which
 *    are nearest; ties go by source index.
 * 2. If a nearer point may lie beyond its candidates, the point is searched alone, wider. If that
 * is not enough, FLANN's kd-tree is asked: for k points, then for all that might tie with the last.
 * 3. If the k-th distance passes what the locale holds, the boxes over the whole cloud are searched
 *    (box_tree.h).
 *
 * So the lists depend only on the cloud. Duplicates share one list. Threads: any, each with its own
 * locale. */
#ifndef STP_PREPROCESS_CLOUD_NEIGHBOURS_H
#define STP_PREPROCESS_CLOUD_NEIGHBOURS_H

#include "preprocess/cloud/locale.h"

/* Neighbour lists of points that are numbered from 0. */
typedef struct stp_neighbours {
    unsigned k;
    uint32_t *indices; /* k numbers per point, nearest first, then STP_NEIGHBOUR_NONE */
} stp_neighbours;

/* Finds the neighbours of the points at `count` places of the locale's cloud, in ascending order.
 * - lists gets k places each, nearest first, then STP_PLACE_NONE; NULL: not wanted.
 * - points[i].spacing gets s = d_k sqrt(pi / k) (docs/algorithms.md, "Radius"), or 0 if the point
 *   has no distinct neighbour.
 *
 * Errors: OUT_OF_MEMORY. */
stp_status stp_neighbours_find(stp_locale *locale, unsigned k, const uint64_t *places,
                               uint32_t count, uint64_t *lists, stp_cloud_point *points,
                               stp_error *err);

#endif
