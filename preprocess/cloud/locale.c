/* A run of cells with its halo. */
#include "preprocess/cloud/locale.h"

#include "base/memory.h"
#include "base/sort.h"
#include "preprocess/cloud/box_tree.h"
#include "preprocess/cloud/cloud_blocks.h"

#include <stdlib.h>
#include <string.h>

/* A cell's spacing is guessed from PROBES of its points: the distance that is greater than
 * PROBE_EIGHTHS eighths of the probed ones. */
#define PROBES 24u
#define PROBE_EIGHTHS 7u
/* A halo has too many points if it has more than GREATEST_SHARE times the cells' own and one more
 * cell's worth. Then halos are halved, at most HALVINGS times. */
#define GREATEST_SHARE 2u
#define HALVINGS 3

/* The distance of the k-th neighbour that most points of a cell do not exceed. */
static double probe(const stp_cloud *cloud, const stp_cell *cell, unsigned k)
{
    double distances[PROBES];
    const uint64_t count = cell->end - cell->begin;
    for (uint32_t i = 0; i < PROBES; i++) {
        stp_nearest_list list = {.capacity = k};
        const uint64_t place = cell->begin + count * i / PROBES;
        stp_box_tree_nearest(cloud, place, &list);
        distances[i] = list.count ? sqrt(list.squared[list.count - 1]) : 0.0;
    }
    stp_sort_doubles(distances, PROBES);
    return distances[PROBES * PROBE_EIGHTHS / 8];
}

typedef struct gathering {
    stp_locale *l;
    size_t limit;
    stp_status status;
    stp_error *err;
} gathering;

static bool box_meets(const stp_dbox *a, const stp_dbox *b, double distance)
{
    return a->min.x - distance <= b->max.x && b->min.x - distance <= a->max.x &&
           a->min.y - distance <= b->max.y && b->min.y - distance <= a->max.y &&
           a->min.z - distance <= b->max.z && b->min.z - distance <= a->max.z;
}

static bool box_is_near(void *context, const stp_dbox *box)
{
    const stp_locale *l = ((gathering *)context)->l;
    for (uint32_t c = 0; c < l->cell_count; c++) {
        const stp_dbox *part = &l->parts[(size_t)c * STP_LOCALE_PARTS];
        bool meets = box_meets(&l->cells[c].box, box, l->halos[c]);
        for (uint32_t i = 0; meets && i < STP_LOCALE_PARTS; i++)
            if (box_meets(&part[i], box, l->halos[c]))
                return true;
    }
    return false;
}

static bool is_near(stp_locale *l, stp_dvec3 p)
{
    const uint32_t count = l->cell_count * STP_LOCALE_PARTS;
    for (uint32_t n = 0, part = l->last; n < count; n++, part = part + 1 < count ? part + 1 : 0) {
        const double halo = l->halos[part / STP_LOCALE_PARTS];
        l->last = part;
        if (stp_dbox_distance_squared(&l->parts[part], p) <= halo * halo)
            return true;
    }
    return false;
}

static bool is_home(const stp_locale *l, uint64_t place)
{
    return place >= l->cells[0].begin && place < l->cells[l->cell_count - 1].end;
}

static bool gather_leaf(void *context, uint64_t begin, uint64_t end)
{
    gathering *g = context;
    stp_locale *l = g->l;
    g->status = stp_grow(&l->places, &l->capacity, l->count + end - begin, sizeof *l->places,
                         "neighbours", g->err);
    if (g->status != STP_OK)
        return false;
    for (uint64_t i = begin; i < end; i++)
        if ((is_home(l, i) || is_near(l, l->cloud->points[i].position)) &&
            !stp_cloud_repeats(l->cloud, i))
            l->places[l->count++] = i;
    return l->count <= g->limit;
}

/* Gathers only the cells' own points. */
static stp_status gather_home(stp_locale *l, stp_error *err)
{
    const uint64_t begin = l->cells[0].begin, end = l->cells[l->cell_count - 1].end;
    stp_status status =
        stp_grow(&l->places, &l->capacity, end - begin, sizeof *l->places, "neighbours", err);
    l->count = 0;
    for (uint64_t i = begin; status == STP_OK && i < end; i++)
        if (!stp_cloud_repeats(l->cloud, i))
            l->places[l->count++] = i;
    for (uint32_t c = 0; c < l->cell_count; c++)
        l->halos[c] = -INFINITY;
    return status;
}

static stp_status gather(stp_locale *l, stp_error *err)
{
    size_t own = l->cells[l->cell_count - 1].end - l->cells[0].begin;
    gathering g = {.l = l,
                   .limit = own + GREATEST_SHARE * (own + STP_CELL_POINTS),
                   .status = STP_OK,
                   .err = err};
    for (int halving = 0; halving <= HALVINGS; halving++) {
        l->count = 0;
        bool all = stp_box_tree_walk(l->cloud, box_is_near, gather_leaf, &g);
        if (all || g.status != STP_OK)
            return g.status;
        for (uint32_t c = 0; c < l->cell_count; c++)
            l->halos[c] *= 0.5;
    }
    return gather_home(l, err);
}

static void make_parts(stp_locale *l)
{
    for (uint32_t i = 0; i < l->cell_count * STP_LOCALE_PARTS; i++) {
        const stp_cell *cell = &l->cells[i / STP_LOCALE_PARTS];
        const uint64_t count = cell->end - cell->begin, n = i % STP_LOCALE_PARTS;
        const uint64_t begin = count * n / STP_LOCALE_PARTS;
        const uint64_t end = count * (n + 1) / STP_LOCALE_PARTS;
        l->parts[i] =
            stp_points_box(l->cloud->points + cell->begin + begin, (uint32_t)(end - begin));
    }
}

static stp_status make_runs(stp_locale *l, stp_error *err)
{
    stp_status status = STP_OK;
    float *axes[3] = {NULL};
    const size_t padded = (l->count + STP_RUN_POINTS - 1) / STP_RUN_POINTS * STP_RUN_POINTS;
    for (int a = 0; a < 3; a++) {
        STP_TRY(stp_alloc_unset(&axes[a], l->count, sizeof *axes[a], "neighbours", err));
        STP_TRY(stp_alloc_unset(&l->axes[a], padded, sizeof *l->axes[a], "neighbours", err));
        for (size_t i = l->count; i < padded; i++)
            l->axes[a][i] = INFINITY;
    }
    for (size_t i = 0; i < l->count; i++) {
        const stp_dvec3 p = l->cloud->points[l->places[i]].position;
        l->axes[0][i] = p.x;
        l->axes[1][i] = p.y;
        l->axes[2][i] = p.z;
    }
    if (l->count > 0) /* among the most points: floats near it are exact, however far others are */
        l->origin = l->cloud->points[l->places[l->count / 2]].position;
    for (uint32_t i = 0; i < l->count; i++) {
        const vec3s p = stp_locale_point(l, i);
        for (int a = 0; a < 3; a++)
            axes[a][i] = p.raw[a];
    }
    STP_TRY(stp_run_tree_create(&l->runs, (const float *const *)axes, (uint32_t)l->count, err));
done:
    for (int a = 0; a < 3; a++)
        free(axes[a]);
    return status;
}

stp_status stp_locale_plant(stp_locale *l, stp_error *err)
{
    stp_status status = STP_OK;
    if (l->tree)
        return STP_OK;
    STP_TRY(stp_alloc_unset(&l->points, 3 * l->count, sizeof *l->points, "neighbours", err));
    STP_TRY(stp_alloc_unset(&l->within, l->count, sizeof *l->within, "neighbours", err));
    for (uint32_t i = 0; i < l->count; i++) {
        const vec3s p = stp_locale_point(l, i);
        memcpy(l->points + 3 * (size_t)i, p.raw, sizeof p.raw);
    }
    l->tree = stp_kd_tree_create(l->points, l->count);
    if (!l->tree)
        status = stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the neighbour search");
done:
    return status;
}

stp_status stp_locale_create(stp_locale *out, const stp_cloud *cloud, uint32_t first, uint32_t end,
                             unsigned k, double reach, stp_error *err)
{
    stp_status status = STP_OK;
    stp_locale l = {.cloud = cloud, .cells = &cloud->cells[first], .cell_count = end - first};
    STP_TRY(stp_alloc(&l.halos, l.cell_count, sizeof *l.halos, "neighbours", err));
    STP_TRY(stp_alloc_unset(&l.parts, (size_t)l.cell_count * STP_LOCALE_PARTS, sizeof *l.parts,
                            "neighbours", err));
    make_parts(&l);
    for (uint32_t c = 0; c < l.cell_count; c++)
        l.halos[c] = reach * probe(cloud, &l.cells[c], k);
    if (l.cells[0].begin > cloud->first) /* the first point may repeat it */
        (void)stp_cloud_has(cloud, l.cells[0].begin - 1);
    if (!cloud->missed || !*cloud->missed) /* else halos may be too wide */
        STP_TRY(gather(&l, err));
    if (!cloud->missed || !*cloud->missed)
        STP_TRY(make_runs(&l, err));
    *out = l;
    l = (stp_locale){0};
done:
    stp_locale_clear(&l);
    return status;
}

void stp_locale_clear(stp_locale *l)
{
    stp_kd_tree_destroy(l->tree);
    stp_run_tree_clear(&l->runs);
    free(l->halos);
    free(l->parts);
    for (int a = 0; a < 3; a++)
        free(l->axes[a]);
    free(l->places);
    free(l->points);
    free(l->within);
    *l = (stp_locale){0};
}

uint32_t stp_locale_find(const stp_locale *l, uint64_t place, size_t *from)
{
    size_t step = 1;
    size_t low = *from, high = *from;
    while (high < l->count && l->places[high] < place) { /* usually close by */
        low = high + 1;
        high += step;
        step *= 2;
    }
    high = high < l->count ? high : l->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (l->places[middle] < place)
            low = middle + 1;
        else
            high = middle;
    }
    *from = low;
    return low < l->count && l->places[low] == place ? (uint32_t)low : STP_LOCALE_NONE;
}

/* Distance from p to the box. Inside: minus the distance to the nearest face. */
static double signed_distance(const stp_dbox *b, stp_dvec3 p)
{
    double room = stp_min(
        stp_min(p.x - b->min.x, b->max.x - p.x),
        stp_min(stp_min(p.y - b->min.y, b->max.y - p.y), stp_min(p.z - b->min.z, b->max.z - p.z)));
    return room >= 0.0 ? -room : sqrt(stp_dbox_distance_squared(b, p));
}

bool stp_locale_holds(stp_locale *l, stp_dvec3 p, double distance)
{
    const uint32_t count = l->cell_count * STP_LOCALE_PARTS;
    for (uint32_t n = 0, part = l->last; n < count; n++, part = part + 1 < count ? part + 1 : 0) {
        l->last = part;
        if (distance + signed_distance(&l->parts[part], p) <= l->halos[part / STP_LOCALE_PARTS])
            return true;
    }
    return false;
}
