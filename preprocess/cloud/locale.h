/* A run of cells and the points around it (its halo): distinct positions, and boxes over runs of
 * them.
 *
 * A cell is a run along the Morton curve, and its box may be mostly empty. So the halo lies around
 * the boxes of the cell's parts, shorter runs. Its width follows the cells' own spacing. The width
 * decides only how often a search in the locale is enough, never the result: stp_locale_holds says
 * if it is not enough. FLANN's kd-tree over the positions is made when the first search asks for
 * it. Threads: one builder, and one searcher. */
#ifndef STP_PREPROCESS_CLOUD_LOCALE_H
#define STP_PREPROCESS_CLOUD_LOCALE_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/cloud/flann_shim.h"
#include "preprocess/cloud/run_tree.h"

/* stp_locale_find: the point is not in the locale. */
#define STP_LOCALE_NONE UINT32_MAX

/* Parts of each cell. */
#define STP_LOCALE_PARTS 16u

typedef struct stp_locale {
    const stp_cloud *cloud;
    const stp_cell *cells; /* of the cloud */
    uint32_t cell_count;
    double *halos;    /* by cell: width of its halo; -infinity: no halo */
    stp_dbox *parts;  /* STP_LOCALE_PARTS of each cell */
    uint32_t last;    /* the part that stp_locale_holds tries first */
    double spread;    /* k-th neighbour distance of the last point searched; 0: unknown */
    uint64_t *places; /* in the cloud, of each position, ascending */
    size_t count, capacity;
    stp_dvec3 origin;  /* the middle one along the curve */
    double *axes[3];   /* coordinates; behind the last, infinite ones fill its run */
    stp_run_tree runs; /* over points less origin */
    stp_kd_tree *tree; /* FLANN's; NULL until stp_locale_plant */
    float *points;     /* of FLANN: 3 per position, less origin */
    uint32_t *within;  /* scratch memory for a search by radius */
} stp_locale;

/* Builds the locale of cells [first, end) of a sorted cloud. A cell's halo is `reach` times the
 * distance of the k-th neighbour wide, as probed at some of its points. If that takes many times as
 * many points as the cells have, the halo is narrower. Errors: OUT_OF_MEMORY. */
stp_status stp_locale_create(stp_locale *out, const stp_cloud *cloud, uint32_t first, uint32_t end,
                             unsigned k, double reach, stp_error *err);
void stp_locale_clear(stp_locale *locale);

/* Makes FLANN's tree, if there is none yet. Errors: OUT_OF_MEMORY. */
stp_status stp_locale_plant(stp_locale *locale, stp_error *err);

/* A position of the locale, less its origin. */
static inline vec3s stp_locale_point(const stp_locale *l, uint32_t at)
{
    return (vec3s){{(float)(l->axes[0][at] - l->origin.x), (float)(l->axes[1][at] - l->origin.y),
                    (float)(l->axes[2][at] - l->origin.z)}};
}

/* At least twice what rounding both ends, less origin, to floats changes of a distance of at most
 * `reach` from `point`: each end is off by 2^-24 of itself. */
static inline double stp_locale_slack(vec3s point, double reach)
{
    return 0x1p-22 * ((double)glms_vec3_norm(point) + reach);
}

/* Returns the number in the locale of a place in the cloud, or STP_LOCALE_NONE. *from: a number
 * that is no greater; the search starts there and moves *from along. For places in ascending order.
 */
uint32_t stp_locale_find(const stp_locale *locale, uint64_t place, size_t *from);

/* Whether the locale holds every point within `distance` of p. Fastest if p is near the last one.
 */
bool stp_locale_holds(stp_locale *locale, stp_dvec3 p, double distance);

#endif
