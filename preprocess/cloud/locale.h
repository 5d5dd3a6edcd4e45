/* A run of cells and what lies around them, in a kd-tree of distinct positions.
 *
 * How far around follows the cells' own spacing: it decides what a search finds at once, and never
 * what it finds in the end, since stp_locale_holds tells where the tree is not enough. Threads: one
 * builder; the scratch room makes it one searcher, too. */
#ifndef STP_PREPROCESS_CLOUD_LOCALE_H
#define STP_PREPROCESS_CLOUD_LOCALE_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/cloud/flann_shim.h"

/* What stp_locale_find gives for points that are not in the tree. */
#define STP_LOCALE_NONE UINT32_MAX

typedef struct stp_locale {
    const stp_cloud *cloud;
    const stp_cell *cells; /* of the cloud */
    uint32_t cell_count;
    double *halos;    /* by cell: width of what is around it, -infinity for nothing */
    uint32_t *places; /* of the positions in the cloud, ascending */
    size_t count, capacity;
    float *points; /* 3 each, about the middle of all */
    double slack;  /* twice what a distance is off by for rounding points to floats */
    stp_kd_tree *tree;
    uint32_t *within; /* room for a search by radius */
} stp_locale;

/* Cells [first, end) of a sorted cloud and about `reach` times the distance of the k-th neighbour
 * around them; less where that would be many times as many points as the cells have. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_locale_create(stp_locale *out, const stp_cloud *cloud, uint32_t first, uint32_t end,
                             unsigned k, double reach, stp_error *err);
void stp_locale_clear(stp_locale *locale);

/* The number of a place of the cloud in the tree, STP_LOCALE_NONE if it is not there. *from: a
 * number no greater, moved along: for places that go up. */
uint32_t stp_locale_find(const stp_locale *locale, uint32_t place, size_t *from);

/* Whether everything so near to p is in the tree. */
bool stp_locale_holds(const stp_locale *locale, stp_dvec3 p, double distance);

#endif
