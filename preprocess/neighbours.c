/* The k nearest distinct positions of every point, cell by cell with a halo. */
#include "preprocess/neighbours.h"

#include "base/memory.h"
#include "preprocess/flann_shim.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define EXTRA_CANDIDATES 3u /* beyond k, so that ties at the end can be told by source */

typedef struct search {
    stp_cloud *cloud;
    stp_neighbours *out;
    const stp_progress *progress;
    atomic_uint_fast64_t done_count;
} search;

typedef struct candidate {
    double distance; /* squared */
    uint32_t index;  /* place in the cloud */
} candidate;

/* Distinct positions of a cell and its halo, in cell-local floats. */
typedef struct locale {
    uint32_t *index;
    float (*points)[3];
    size_t count, capacity;
    size_t point_capacity;
    stp_dvec3 origin;
} locale;

static bool same_position(const stp_cloud_point *a, const stp_cloud_point *b)
{
    return a->position.x == b->position.x && a->position.y == b->position.y &&
           a->position.z == b->position.z;
}

static double box_distance(const stp_dbox *box, stp_dvec3 p)
{
    double dx = fmax(0.0, fmax(box->min.x - p.x, p.x - box->max.x));
    double dy = fmax(0.0, fmax(box->min.y - p.y, p.y - box->max.y));
    double dz = fmax(0.0, fmax(box->min.z - p.z, p.z - box->max.z));
    return sqrt(dx * dx + dy * dy + dz * dz);
}

static bool boxes_near(const stp_dbox *a, const stp_dbox *b, double distance)
{
    return a->min.x - distance <= b->max.x && b->min.x - distance <= a->max.x &&
           a->min.y - distance <= b->max.y && b->min.y - distance <= a->max.y &&
           a->min.z - distance <= b->max.z && b->min.z - distance <= a->max.z;
}

static stp_status locale_add(locale *l, const stp_cloud *cloud, uint32_t index, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_grow(&l->index, &l->capacity, l->count + 1, sizeof *l->index, "neighbours", err));
    STP_TRY(stp_grow(&l->points, &l->point_capacity, l->count + 1, sizeof *l->points, "neighbours",
                     err));
    stp_dvec3 p = stp_dvec3_sub(cloud->points[index].position, l->origin);
    l->points[l->count][0] = (float)p.x;
    l->points[l->count][1] = (float)p.y;
    l->points[l->count][2] = (float)p.z;
    l->index[l->count++] = index;
done:
    return status;
}

/* Equal positions follow each other in a cell, since they share a Morton code and ties are sorted.
 */
static stp_status locale_gather(locale *l, const stp_cloud *cloud, const stp_cell *home,
                                double halo, stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t c = 0; c < cloud->cell_count; c++) {
        const stp_cell *cell = &cloud->cells[c];
        if (!boxes_near(&cell->box, &home->box, halo))
            continue;
        for (uint32_t i = cell->begin; i < cell->end; i++) {
            if (i > cell->begin && same_position(&cloud->points[i], &cloud->points[i - 1]))
                continue;
            if (cell != home && box_distance(&home->box, cloud->points[i].position) > halo)
                continue;
            STP_TRY(locale_add(l, cloud, i, err));
        }
    }
done:
    return status;
}

static int compare_candidates(const stp_cloud *cloud, const candidate *a, const candidate *b)
{
    if (a->distance != b->distance)
        return a->distance < b->distance ? -1 : 1;
    uint32_t p = cloud->points[a->index].source;
    uint32_t q = cloud->points[b->index].source;
    return p < q ? -1 : p > q;
}

/* Inserts into a sorted list of at most capacity; returns the new count. */
static size_t insert(const stp_cloud *cloud, candidate *list, size_t count, size_t capacity,
                     candidate new)
{
    if (count == capacity) {
        if (compare_candidates(cloud, &new, &list[count - 1]) >= 0)
            return count;
        count--;
    }
    size_t at = count;
    while (at > 0 && compare_candidates(cloud, &new, &list[at - 1]) < 0) {
        list[at] = list[at - 1];
        at--;
    }
    list[at] = new;
    return count + 1;
}

/* Every cell the ball of the k-th distance meets, point by point: rare, and exact. */
static size_t search_everywhere(const stp_cloud *cloud, uint32_t self, candidate *list,
                                size_t count, size_t k)
{
    stp_dvec3 p = cloud->points[self].position;
    double reach = count == k ? list[k - 1].distance : INFINITY;
    count = 0;
    for (uint32_t c = 0; c < cloud->cell_count; c++) {
        const stp_cell *cell = &cloud->cells[c];
        double gap = box_distance(&cell->box, p);
        if (gap * gap > reach)
            continue;
        for (uint32_t i = cell->begin; i < cell->end; i++) {
            if (i > cell->begin && same_position(&cloud->points[i], &cloud->points[i - 1]))
                continue;
            stp_dvec3 d = stp_dvec3_sub(cloud->points[i].position, p);
            double distance = stp_dvec3_dot(d, d);
            if (distance == 0.0 || distance > reach)
                continue;
            count = insert(cloud, list, count, k, (candidate){distance, i});
            if (count == k)
                reach = fmin(reach, list[k - 1].distance);
        }
    }
    return count;
}

static bool inside_halo(const stp_cell *cell, stp_dvec3 p, double halo, double distance)
{
    const stp_dbox *b = &cell->box;
    double room =
        fmin(fmin(p.x - b->min.x, b->max.x - p.x),
             fmin(fmin(p.y - b->min.y, b->max.y - p.y), fmin(p.z - b->min.z, b->max.z - p.z)));
    return distance <= room + halo;
}

static stp_status find_point(search *s, const stp_cell *cell, const locale *l, stp_kd_tree *tree,
                             double halo, uint32_t self, stp_error *err)
{
    stp_cloud *cloud = s->cloud;
    size_t k = s->out->k;
    int32_t found[STP_NEIGHBOURS_LIMIT + EXTRA_CANDIDATES + 1];
    float distances[STP_NEIGHBOURS_LIMIT + EXTRA_CANDIDATES + 1];
    candidate list[STP_NEIGHBOURS_LIMIT];
    stp_cloud_point *point = &cloud->points[self];
    stp_dvec3 local = stp_dvec3_sub(point->position, l->origin);
    float query[3] = {(float)local.x, (float)local.y, (float)local.z};
    int got = stp_kd_tree_nearest(tree, query, (int)(k + EXTRA_CANDIDATES + 1), found, distances);
    if (got < 0)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the neighbour search");
    size_t count = 0;
    for (int i = 0; i < got; i++) {
        uint32_t index = l->index[found[i]];
        stp_dvec3 d = stp_dvec3_sub(cloud->points[index].position, point->position);
        double distance = stp_dvec3_dot(d, d);
        if (distance > 0.0)
            count = insert(cloud, list, count, k, (candidate){distance, index});
    }
    if (count < k || !inside_halo(cell, point->position, halo, sqrt(list[k - 1].distance)))
        count = search_everywhere(cloud, self, list, count, k);
    uint32_t *out = s->out->indices + (size_t)self * k;
    for (size_t i = 0; i < k; i++)
        out[i] = i < count ? list[i].index : STP_NEIGHBOUR_NONE;
    point->spacing = count ? (float)sqrt(list[count - 1].distance * M_PI / (double)count) : 0.0f;
    return STP_OK;
}

/* About four sample spacings of a surface that fills the cell's box with its points. */
static double halo_width(const stp_cell *cell)
{
    double diagonal = stp_dvec3_length(stp_dvec3_sub(cell->box.max, cell->box.min));
    return 3.0 * diagonal / sqrt((double)(cell->end - cell->begin));
}

static stp_status find_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    search *s = context;
    stp_cloud *cloud = s->cloud;
    const stp_cell *cell = &cloud->cells[index];
    size_t k = s->out->k;
    double halo = halo_width(cell);
    locale l = {.origin = stp_dvec3_scale(stp_dvec3_add(cell->box.min, cell->box.max), 0.5)};
    stp_kd_tree *tree = NULL;
    (void)worker;
    STP_TRY(locale_gather(&l, cloud, cell, halo, err));
    tree = stp_kd_tree_create(&l.points[0][0], l.count);
    if (!tree) {
        status = stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the neighbour search");
        goto done;
    }
    for (uint32_t i = cell->begin; i < cell->end; i++) {
        if (i > cell->begin && same_position(&cloud->points[i], &cloud->points[i - 1])) {
            memcpy(s->out->indices + i * k, s->out->indices + (i - 1) * k,
                   k * sizeof *s->out->indices);
            cloud->points[i].spacing = cloud->points[i - 1].spacing;
            continue;
        }
        STP_TRY(find_point(s, cell, &l, tree, halo, i, err));
    }
    uint64_t done = atomic_fetch_add(&s->done_count, cell->end - cell->begin);
    status = stp_progress_update(s->progress, "neighbours", done + cell->end - cell->begin,
                                 cloud->count, err);
done:
    stp_kd_tree_destroy(tree);
    free(l.index);
    free(l.points);
    return status;
}

stp_status stp_neighbours_find(stp_neighbours *out, stp_cloud *cloud, unsigned k, stp_pool *pool,
                               const stp_progress *progress, stp_error *err)
{
    stp_status status = STP_OK;
    stp_neighbours result = {.k = k};
    if (k < 3 || k > STP_NEIGHBOURS_LIMIT)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "%u neighbours: give 3 to %d", k,
                             STP_NEIGHBOURS_LIMIT);
    STP_TRY(stp_alloc(&result.indices, (size_t)cloud->count * k, sizeof *result.indices,
                      "neighbours", err));
    search s = {.cloud = cloud, .out = &result, .progress = progress};
    STP_TRY(stp_pool_run(pool, cloud->cell_count, find_cell, &s, err));
    *out = result;
    result.indices = NULL;
done:
    free(result.indices);
    return status;
}

void stp_neighbours_clear(stp_neighbours *neighbours)
{
    free(neighbours->indices);
    *neighbours = (stp_neighbours){0};
}
