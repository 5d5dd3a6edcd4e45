/* A run of cells and the points around it (its halo), in a kd-tree of distinct positions.
 *
 * The halo's width follows the cells' own spacing. The width decides only how often a search in the
 * tree is enough, never the result: stp_locale_holds says if the tree is not enough. Threads: one
 * builder. A search uses the locale's scratch memory, so one searcher. */
#ifndef STP_PREPROCESS_CLOUD_LOCALE_H
#define STP_PREPROCESS_CLOUD_LOCALE_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/cloud/flann_shim.h"

/* stp_locale_find: the point is not in the tree. */
#define STP_LOCALE_NONE UINT32_MAX

typedef struct stp_locale {
    const stp_cloud *cloud;
    const stp_cell *cells; /* of the cloud */
    uint32_t cell_count;
    double *halos;    /* by cell: width of its halo; -infinity: no halo */
    uint32_t *places; /* in the cloud, of each position, ascending */
    size_t count, capacity;
    float *points; /* 3 per position, relative to the middle of all */
    double slack;  /* twice the error of a distance from rounding points to floats */
    stp_kd_tree *tree;
    uint32_t *within; /* scratch memory for a search by radius */
} stp_locale;

/* Builds the locale of cells [first, end) of a sorted cloud. A cell's halo is `reach` times the
 * distance of the k-th neighbour wide, as probed at some of its points. If that takes many times as
 * many points as the cells have, the halo is narrower. Errors: OUT_OF_MEMORY. */
stp_status stp_locale_create(stp_locale *out, const stp_cloud *cloud, uint32_t first, uint32_t end,
                             unsigned k, double reach, stp_error *err);
void stp_locale_clear(stp_locale *locale);

/* Returns the number in the tree of a place in the cloud, or STP_LOCALE_NONE. *from: a number that
 * is no greater; the search starts there and moves *from along. For places in ascending order. */
uint32_t stp_locale_find(const stp_locale *locale, uint32_t place, size_t *from);

/* Whether the tree holds every point within `distance` of p. */
bool stp_locale_holds(const stp_locale *locale, stp_dvec3 p, double distance);

#endif
