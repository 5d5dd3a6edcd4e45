/* The points of a scan in memory, in Morton order, and the cells they fall into.
 *
 * A cell is a run of the Morton order. Neighbours are searched cell by cell, and each cell becomes
 * a leaf chunk. Cells depend only on the points, never on threads or memory. Does not read files.
 * Threads: one builder. */
#ifndef STP_PREPROCESS_CLOUD_CLOUD_H
#define STP_PREPROCESS_CLOUD_CLOUD_H

#include "base/pool.h"
#include "base/spill.h"
#include "base/vec.h"

#include <stdbool.h>
#include <stdint.h>

/* Most points of a cell: as many as a chunk holds. */
#define STP_CELL_POINTS 65536u

/* Points' places in the cloud and in the input have so many bits. */
#define STP_PLACE_BITS 38
#define STP_PLACE_MASK ((UINT64_C(1) << STP_PLACE_BITS) - 1)

/* The sheet of a point that belongs to no sheet. */
#define STP_SHEET_NONE UINT32_MAX

typedef enum stp_given {
    STP_GIVEN_NOT = 0,
    STP_GIVEN_INPUT,
    STP_GIVEN_IMAGE /* image_normals.h */
} stp_given;

typedef struct stp_cloud_point {
    stp_dvec3 position;
    vec3s normal;  /* unit; zero if unknown; STP_MARK_TURNED turns its sign */
    float spacing; /* local sample spacing, world units */
    uint16_t rgb[3];
    uint16_t intensity;
    uint64_t source : STP_PLACE_BITS; /* place in the input */
    uint64_t station : 16;            /* the station that saw the point, from 1; 0: unknown */
    uint64_t class_id : 8;
    uint64_t given : 2; /* where the normal comes from: stp_given; NOT: from near points */
} stp_cloud_point;

typedef struct stp_cell {
    uint64_t begin, end; /* run of points */
    stp_dbox box;
} stp_cell;

/* Bits: what is known about a point. */
#define STP_MARK_TURNED 1u     /* its normal has the other sign */
#define STP_MARK_ORIENTED 2u   /* its outside is known */
#define STP_MARK_OUTLIER 4u    /* far from everything else */
#define STP_MARK_CLOSED 8u     /* its back is proven hidden (enclosure.h) */
#define STP_MARK_WIDE 16u      /* because of noise, its plane has more than the nearest points */
#define STP_MARK_WIDEST 32u    /* likewise, and still more points */
#define STP_MARK_SCATTERED 64u /* it and its neighbours fill a volume (scattered.h) */

/* Enough for 2^STP_PLACE_BITS points. */
#define STP_BOX_TIERS 9

/* A tree of boxes over runs of the order (box_tree.h). */
typedef struct stp_box_tree {
    stp_dbox *boxes;                   /* tier by tier, leaves first */
    uint64_t begin[STP_BOX_TIERS + 1]; /* where each tier begins; then the end of the last tier */
    unsigned tier_count;               /* 0: no points */
} stp_box_tree;

struct stp_cloud_blocks;

typedef struct stp_cloud {
    stp_cloud_point *points;
    uint32_t *sheets;      /* by point: the smooth piece of surface it lies on, or STP_SHEET_NONE */
    uint8_t *marks;        /* by point: STP_MARK_* */
    uint32_t *pixels;      /* by record: its pixel, if images have them told (scan.h); else NULL */
    uint64_t first;        /* place of the first point: 0, but in tests */
    uint64_t first_record; /* number of the first record; likewise */
    uint64_t count, capacity;
    stp_spill *spill; /* where arrays by point lie, borrowed; NULL: plain memory */
    stp_dbox box;
    stp_cell *cells;
    uint32_t cell_count;
    stp_box_tree tree; /* over the sorted points */

    /* Where the points are if ranks share them (cloud_blocks.h); NULL: all are here. */
    struct stp_cloud_blocks *blocks;
    bool *missed; /* becomes true if a point is asked for that is not here; NULL: not wanted */
} stp_cloud;

/* The first point; NULL if there is no array. */
static inline stp_cloud_point *stp_cloud_begin(const stp_cloud *cloud)
{
    return cloud->points ? cloud->points + cloud->first : NULL;
}
/* stp_pool_run for tasks that walk through arrays by point. Keeps to the spill's memory limit
 * between tasks. */
stp_status stp_cloud_run(const stp_cloud *cloud, stp_pool *pool, size_t count, stp_pool_task *task,
                         void *context, stp_error *err);
/* The same, a task for each cell that this process owns (cloud_blocks.h); its index is the cell's.
 */
stp_status stp_cloud_run_own(const stp_cloud *cloud, stp_pool *pool, stp_pool_task *task,
                             void *context, stp_error *err);
/* Call this at each turn of a loop over every stride-th point: it keeps to the memory limit. */
static inline void stp_cloud_stride(stp_spill *spill, uint64_t i, uint64_t stride)
{
    if (i % 65536u < stride)
        stp_spill_relieve(spill);
}
/* Like stp_cloud_stride, in a loop over all points. */
static inline void stp_cloud_step(stp_spill *spill, uint64_t i)
{
    stp_cloud_stride(spill, i, 1);
}
/* The box around `count` consecutive points. */
static inline stp_dbox stp_points_box(const stp_cloud_point *points, uint64_t count)
{
    stp_dbox box = stp_dbox_empty();
    for (uint64_t i = 0; i < count; i++)
        stp_dbox_add(&box, points[i].position);
    return box;
}

/* Whether the point has the same position as the one before. Equal positions are consecutive. */
static inline bool stp_cloud_repeats(const stp_cloud *cloud, uint64_t i)
{
    if (i == cloud->first)
        return false;
    stp_dvec3 p = cloud->points[i].position, q = cloud->points[i - 1].position;
    return p.x == q.x && p.y == q.y && p.z == q.z;
}

static inline bool stp_has_normal(const stp_cloud_point *p)
{
    return p->normal.x != 0.0f || p->normal.y != 0.0f || p->normal.z != 0.0f;
}

/* The normal with its sign. */
static inline vec3s stp_cloud_normal(const stp_cloud *cloud, uint64_t i)
{
    vec3s normal = cloud->points[i].normal;
    return cloud->marks[i] & STP_MARK_TURNED ? glms_vec3_negate(normal) : normal;
}

#endif
