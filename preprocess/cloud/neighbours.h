/* The k nearest distinct positions of points, exactly.
 *
 * FLANN's kd-tree over a locale gives candidates by float distances, once for a few points that
 * follow each other; the lists are made of them in double, ties by source index. A point for which
 * nearer ones may lie beyond its candidates is searched alone: where more points might tie with the
 * last one, all as near are compared, and where the k-th distance passes what the locale holds, the
 * boxes over the whole cloud are (box_tree.h). So the lists depend on the cloud alone. Duplicates
 * share one list. Threads: any, a locale each. */
#ifndef STP_PREPROCESS_CLOUD_NEIGHBOURS_H
#define STP_PREPROCESS_CLOUD_NEIGHBOURS_H

#include "preprocess/cloud/locale.h"

/* Lists of points that are numbered from 0. */
typedef struct stp_neighbours {
    unsigned k;
    uint32_t *indices; /* k numbers by point, nearest first, STP_NEIGHBOUR_NONE at the end */
} stp_neighbours;

/* Writes the lists of the points at count places of the locale's cloud, ascending: to lists k
 * places each (NULL: not wanted), and to points[i].spacing s = d_k sqrt(pi / k)
 * (docs/algorithms.md, "Radius"; 0 where a point has no distinct neighbour). Errors: OUT_OF_MEMORY.
 */
stp_status stp_neighbours_find(const stp_locale *locale, unsigned k, const uint32_t *places,
                               uint32_t count, uint32_t *lists, stp_cloud_point *points,
                               stp_error *err);

#endif
