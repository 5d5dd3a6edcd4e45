/* The points of a scan in memory, in Morton order, and the cells they fall into.
 *
 * A cell is a run of the order: the unit of neighbour search and the leaf chunk to be. Cells depend
 * on the points alone, never on threads or memory. Does not read files. Threads: one builder. */
#ifndef STP_PREPROCESS_CLOUD_CLOUD_H
#define STP_PREPROCESS_CLOUD_CLOUD_H

#include "base/pool.h"
#include "base/spill.h"
#include "base/vec.h"
#include "preprocess/cloud/box_tree.h"

#include <stdbool.h>
#include <stdint.h>

/* Most points of a cell: as many as a chunk holds. */
#define STP_CELL_POINTS 65536u

/* Of points that belong to no sheet. */
#define STP_SHEET_NONE UINT32_MAX

typedef enum stp_given {
    STP_GIVEN_NOT = 0,
    STP_GIVEN_INPUT,
    STP_GIVEN_IMAGE /* image_normals.h */
} stp_given;

typedef struct stp_cloud_point {
    stp_dvec3 position;
    vec3s normal;    /* unit, or zero where unknown; its sign is its mark's to turn */
    float spacing;   /* local sample spacing, world units */
    uint32_t source; /* place in the input */
    uint16_t rgb[3];
    uint16_t intensity;
    uint16_t station; /* whose point it is, counted from 1; 0: unknown */
    uint8_t class_id;
    uint8_t given; /* what the normal is from, if not from near points: stp_given */
} stp_cloud_point;

typedef struct stp_cell {
    uint32_t begin, end; /* run of points */
    stp_dbox box;
} stp_cell;

/* What is found of a point: bits. */
#define STP_MARK_TURNED 1u   /* its normal's sign is the other one */
#define STP_MARK_ORIENTED 2u /* which side is the outside is known */
#define STP_MARK_OUTLIER 4u  /* far from everything else */
#define STP_MARK_CLOSED 8u   /* its back is proven hidden (enclosure.h) */
#define STP_MARK_WIDE 16u    /* its plane is wider than the nearest neighbours, because of noise, */
#define STP_MARK_WIDEST 32u  /* or wider still */

typedef struct stp_cloud {
    stp_cloud_point *points;
    uint32_t *sheets; /* by point: which smooth piece of surface it lies on; STP_SHEET_NONE */
    uint8_t *marks;   /* by point: STP_MARK_* */
    uint32_t count, capacity;
    stp_spill *spill; /* where arrays by point lie, borrowed; NULL: plain memory */
    stp_dbox box;
    stp_cell *cells;
    uint32_t cell_count;
    stp_box_tree tree; /* over the sorted points */
} stp_cloud;

/* Room for so many points, none yet. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_cloud_create(stp_cloud *out, uint32_t capacity, stp_spill *spill, stp_error *err);
/* Sorts the points along the Morton curve of their bounding cube (ties by coordinates, then by
 * source), cuts the order into cells and makes room for what will be found of each point. Errors:
 * OUT_OF_MEMORY, IO. */
stp_status stp_cloud_sort(stp_cloud *cloud, stp_pool *pool, stp_error *err);
/* Frees what the sort made: the points may change, and be sorted again. */
void stp_cloud_unsort(stp_cloud *cloud);
/* Gives room in files back: a cell's points, sheets and marks are not needed any more. */
void stp_cloud_forget(stp_cloud *cloud, const stp_cell *cell);
/* stp_pool_run for tasks that walk through arrays by point: keeps to the spill's limit between
 * them. */
stp_status stp_cloud_run(const stp_cloud *cloud, stp_pool *pool, size_t count, stp_pool_task *task,
                         void *context, stp_error *err);
/* At each turn of a loop over every stride-th point: keeps to the limit. */
static inline void stp_cloud_stride(stp_spill *spill, uint64_t i, uint32_t stride)
{
    if (i % 65536u < stride)
        stp_spill_relieve(spill);
}
/* Likewise over all points. */
static inline void stp_cloud_step(stp_spill *spill, uint32_t i)
{
    stp_cloud_stride(spill, i, 1);
}
/* Around so many points that follow each other. */
static inline stp_dbox stp_points_box(const stp_cloud_point *points, uint32_t count)
{
    stp_dbox box = stp_dbox_empty();
    for (uint32_t i = 0; i < count; i++)
        stp_dbox_add(&box, points[i].position);
    return box;
}

/* Whether the point lies where the one before it does: equal positions follow each other. */
static inline bool stp_cloud_repeats(const stp_cloud *cloud, uint32_t i)
{
    if (i == 0)
        return false;
    stp_dvec3 p = cloud->points[i].position, q = cloud->points[i - 1].position;
    return p.x == q.x && p.y == q.y && p.z == q.z;
}

static inline bool stp_has_normal(const stp_cloud_point *p)
{
    return p->normal.x != 0.0f || p->normal.y != 0.0f || p->normal.z != 0.0f;
}

/* The normal with its sign. */
static inline vec3s stp_cloud_normal(const stp_cloud *cloud, uint32_t i)
{
    vec3s normal = cloud->points[i].normal;
    return cloud->marks[i] & STP_MARK_TURNED ? glms_vec3_negate(normal) : normal;
}

/* Frees what the cloud owns. */
void stp_cloud_clear(stp_cloud *cloud);

#endif
