/* Finds points, and small groups of points, far from everything else. */
#include "preprocess/cloud/outliers.h"

#include "base/memory.h"
#include "preprocess/cloud/unit.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Rings around a cell: its neighbours, and their neighbours for the spacings of the first. */
#define RINGS 2u
/* Rows of the table per task. */
#define BLOCK_ROWS 4096u

/* Bits: what is known about a point. Neither bit: joined with few, or a repeated position. */
#define JOINED 1u /* with more than k positions: kept */
#define TOLD 2u   /* near a kept point: kept, too */

/* Neighbour lists of the points in doubt. Duplicates have one row, that of the first. */
typedef struct table {
    uint32_t count;
    uint32_t *points; /* ascending */
    uint32_t *lists;  /* k each */
    float *spacings;  /* their own */
} table;

typedef struct finder {
    stp_cloud *cloud;
    unsigned k;
    double distance; /* in spacings */
    const stp_progress *progress;
    float *spacings;          /* local spacings by point; a duplicate's is that of the first */
    _Atomic(uint8_t) *states; /* by point */
    table *tables;            /* by cell */
    table doubtful;           /* the tables of all cells */
    atomic_uint_fast64_t done_count;
    atomic_bool any_joined;
} finder;

static uint8_t state_of(const finder *f, uint32_t point)
{
    return atomic_load_explicit(&f->states[point], memory_order_relaxed);
}

static void add_state(const finder *f, uint32_t point, uint8_t bit)
{
    if (!(state_of(f, point) & bit)) /* a read is cheaper */
        atomic_fetch_or_explicit(&f->states[point], bit, memory_order_relaxed);
}

/* Whether two points are within `distance` times this spacing. */
static bool within(const finder *f, const stp_cloud *cloud, uint32_t a, uint32_t b, float spacing)
{
    stp_dvec3 d = stp_dvec3_sub(cloud->points[a].position, cloud->points[b].position);
    double reach = f->distance * (double)spacing;
    return stp_dvec3_dot(d, d) <= reach * reach;
}

/* ---- tables ---- */

static stp_status table_create(table *t, const finder *f, uint32_t capacity, stp_error *err)
{
    stp_status status = STP_OK;
    stp_spill *spill = f->cloud->spill;
    STP_TRY(stp_spill_alloc(spill, &t->points, capacity, sizeof *t->points, "outliers", err));
    STP_TRY(stp_spill_alloc(spill, &t->lists, (size_t)capacity * f->k, sizeof *t->lists, "outliers",
                            err));
    STP_TRY(stp_spill_alloc(spill, &t->spacings, capacity, sizeof *t->spacings, "outliers", err));
done:
    return status;
}

static void table_clear(table *t, const finder *f)
{
    stp_spill_free(f->cloud->spill, t->points);
    stp_spill_free(f->cloud->spill, t->lists);
    stp_spill_free(f->cloud->spill, t->spacings);
    *t = (table){0};
}

/* The row of a point in doubt. */
static uint32_t row_of(const table *t, uint32_t point)
{
    uint32_t low = 0, high = t->count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (t->points[middle] <= point)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Joins the cells' tables. */
static stp_status gather_tables(finder *f, stp_error *err)
{
    stp_status status = STP_OK;
    table *all = &f->doubtful;
    uint32_t count = 0;
    for (uint32_t c = 0; c < f->cloud->cell_count; c++)
        count += f->tables[c].count;
    STP_TRY(table_create(all, f, count, err));
    for (uint32_t c = 0; c < f->cloud->cell_count; c++) {
        const table *t = &f->tables[c];
        stp_spill_relieve(f->cloud->spill);
        if (t->count > 0) {
            memcpy(all->points + all->count, t->points, t->count * sizeof *t->points);
            memcpy(all->spacings + all->count, t->spacings, t->count * sizeof *t->spacings);
            memcpy(all->lists + (size_t)all->count * f->k, t->lists,
                   (size_t)t->count * f->k * sizeof *t->lists);
            all->count += t->count;
        }
        table_clear(&f->tables[c], f);
    }
done:
    return status;
}

/* ---- cell by cell ---- */

/* The lower median of at least one value, by counting, without branches. */
static float median(const float *values, unsigned count)
{
    unsigned middle = (count - 1) / 2;
    for (unsigned i = 0; i + 1 < count; i++) {
        unsigned less = 0, equal = 0;
        for (unsigned n = 0; n < count; n++) {
            less += values[n] < values[i];
            equal += values[n] == values[i];
        }
        if (less <= middle && middle < less + equal)
            return values[i];
    }
    return values[count - 1];
}

static float local_spacing(const stp_unit *unit, uint32_t self)
{
    const uint32_t *list = unit->neighbours.indices + (size_t)self * unit->neighbours.k;
    float values[STP_NEIGHBOURS_LIMIT];
    unsigned count = 0;
    for (; count < unit->neighbours.k && list[count] != STP_NEIGHBOUR_NONE; count++)
        values[count] = unit->cloud.points[list[count]].spacing;
    float own = unit->cloud.points[self].spacing;
    return count > 0 ? fminf(own, median(values, count)) : own;
}

/* Whether one step reaches all k neighbours. With the point's own these are k + 1 positions. */
static bool joined_with_all(const finder *f, const stp_unit *unit, const float *spacings,
                            uint32_t self)
{
    const uint32_t *list = unit->neighbours.indices + (size_t)self * f->k;
    for (unsigned n = 0; n < f->k; n++)
        if (list[n] == STP_NEIGHBOUR_NONE ||
            !within(f, &unit->cloud, self, list[n], fminf(spacings[self], spacings[list[n]])))
            return false;
    return true;
}

static uint32_t place_of(const stp_unit *unit, uint32_t number)
{
    return number == STP_NEIGHBOUR_NONE ? STP_NEIGHBOUR_NONE : unit->places[number];
}

/* Splits the cell's points into joined and doubtful ones. The neighbours of joined points are kept,
 * too. */
static stp_status sort_out(finder *f, const stp_unit *unit, const float *spacings, table *doubtful,
                           stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t first = unit->places[0], count = 0;
    for (uint32_t i = 0; i < unit->ring_end[0]; i++) {
        const uint32_t *list = unit->neighbours.indices + (size_t)i * f->k;
        f->spacings[first + i] = spacings[i];
        if (stp_cloud_repeats(f->cloud, first + i))
            continue;
        if (!joined_with_all(f, unit, spacings, i)) {
            count++;
            continue;
        }
        add_state(f, first + i, JOINED);
        atomic_store_explicit(&f->any_joined, true, memory_order_relaxed);
        for (unsigned n = 0; n < f->k; n++)
            add_state(f, unit->places[list[n]], TOLD);
    }
    STP_TRY(table_create(doubtful, f, count, err));
    for (uint32_t i = 0; i < unit->ring_end[0]; i++) {
        if (state_of(f, first + i) & JOINED || stp_cloud_repeats(f->cloud, first + i))
            continue;
        uint32_t row = doubtful->count++;
        doubtful->points[row] = first + i;
        doubtful->spacings[row] = unit->cloud.points[i].spacing;
        for (unsigned n = 0; n < f->k; n++)
            doubtful->lists[(size_t)row * f->k + n] =
                place_of(unit, unit->neighbours.indices[(size_t)i * f->k + n]);
    }
done:
    return status;
}

static stp_status find_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    finder *f = context;
    stp_unit unit = {0};
    float *spacings = NULL;
    (void)worker;
    STP_TRY(
        stp_unit_create(&unit, f->cloud, (uint32_t)index, (uint32_t)index + 1, f->k, RINGS, err));
    uint32_t inner = stp_unit_inner(&unit, 1);
    STP_TRY(stp_alloc(&spacings, inner, sizeof *spacings, "outliers", err));
    for (uint32_t i = 0; i < inner; i++)
        spacings[i] = local_spacing(&unit, i);
    STP_TRY(sort_out(f, &unit, spacings, &f->tables[index], err));
    uint64_t done = atomic_fetch_add(&f->done_count, unit.ring_end[0]) + unit.ring_end[0];
    status = stp_progress_update(f->progress, "outliers", done, f->cloud->count, err);
done:
    free(spacings);
    stp_unit_clear(&unit);
    return status;
}

/* ---- the doubtful ones ---- */

static bool among(const uint32_t *points, unsigned count, uint32_t wanted)
{
    for (unsigned i = 0; i < count; i++)
        if (points[i] == wanted)
            return true;
    return false;
}

/* Whether steps reach more than k positions: that many in doubt, or one that is joined. */
static bool joined_with_many(const finder *f, uint32_t row)
{
    const table *t = &f->doubtful;
    uint32_t reached[STP_NEIGHBOURS_LIMIT + 1] = {t->points[row]};
    unsigned count = 1;
    for (unsigned at = 0; at < count; at++) {
        uint32_t from = reached[at];
        const uint32_t *list = t->lists + (size_t)(at > 0 ? row_of(t, from) : row) * f->k;
        for (unsigned n = 0; n < f->k && list[n] != STP_NEIGHBOUR_NONE; n++) {
            uint32_t to = list[n];
            if (!within(f, f->cloud, from, to, fminf(f->spacings[from], f->spacings[to])) ||
                among(reached, count, to))
                continue;
            if (count == f->k || state_of(f, to) & JOINED)
                return true;
            reached[count++] = to;
        }
    }
    return false;
}

static stp_status join_block(void *context, size_t block, unsigned worker, stp_error *err)
{
    finder *f = context;
    uint32_t begin = (uint32_t)block * BLOCK_ROWS, left = f->doubtful.count - begin;
    uint32_t end = left < BLOCK_ROWS ? begin + left : begin + BLOCK_ROWS;
    (void)worker;
    for (uint32_t row = begin; row < end; row++) {
        if (!joined_with_many(f, row))
            continue;
        add_state(f, f->doubtful.points[row], JOINED);
        atomic_store_explicit(&f->any_joined, true, memory_order_relaxed);
    }
    return stp_progress_update(f->progress, "outliers", f->cloud->count, f->cloud->count, err);
}

/* Keeps the neighbours of a kept point within `distance` of its own spacings. */
static void tell_neighbours(const finder *f, uint32_t row)
{
    const table *t = &f->doubtful;
    const uint32_t *list = t->lists + (size_t)row * f->k;
    for (unsigned n = 0; n < f->k && list[n] != STP_NEIGHBOUR_NONE; n++)
        if (within(f, f->cloud, t->points[row], list[n], t->spacings[row]))
            add_state(f, list[n], TOLD);
}

static bool near_kept(const finder *f, uint32_t row)
{
    const table *t = &f->doubtful;
    const uint32_t *list = t->lists + (size_t)row * f->k;
    for (unsigned n = 0; n < f->k && list[n] != STP_NEIGHBOUR_NONE; n++)
        if (state_of(f, list[n]) != 0 &&
            within(f, f->cloud, t->points[row], list[n], f->spacings[list[n]]))
            return true;
    return false;
}

/* Repeats rule 2 until nothing changes. */
static stp_status decide(finder *f, stp_error *err)
{
    uint32_t *rows = NULL, count = f->doubtful.count;
    stp_status status =
        stp_spill_alloc(f->cloud->spill, &rows, count, sizeof *rows, "outliers", err);
    for (uint32_t i = 0; status == STP_OK && i < count; i++)
        rows[i] = i;
    for (bool changed = status == STP_OK; changed;) {
        uint32_t left = 0;
        changed = false;
        for (uint32_t i = 0; i < count; i++, stp_cloud_step(f->cloud->spill, i)) {
            uint32_t point = f->doubtful.points[rows[i]];
            if (state_of(f, point) == 0 && !near_kept(f, rows[i])) {
                rows[left++] = rows[i];
                continue;
            }
            add_state(f, point, TOLD);
            tell_neighbours(f, rows[i]);
            changed = true;
        }
        count = left;
    }
    stp_spill_free(f->cloud->spill, rows);
    return status;
}

static uint32_t mark(const finder *f)
{
    uint32_t count = 0;
    bool outlier = false;
    for (uint32_t i = 0; i < f->cloud->count; i++, stp_cloud_step(f->cloud->spill, i)) {
        outlier = stp_cloud_repeats(f->cloud, i) ? outlier : state_of(f, i) == 0;
        f->cloud->marks[i] |= outlier ? STP_MARK_OUTLIER : 0;
        count += outlier;
    }
    return count;
}

stp_status stp_outliers_find(stp_cloud *cloud, unsigned k, double distance, stp_pool *pool,
                             const stp_progress *progress, uint32_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    finder f = {.cloud = cloud, .k = k, .distance = distance, .progress = progress};
    STP_TRY(stp_spill_alloc(cloud->spill, &f.spacings, cloud->count, sizeof *f.spacings, "outliers",
                            err));
    STP_TRY(
        stp_spill_alloc(cloud->spill, &f.states, cloud->count, sizeof *f.states, "outliers", err));
    STP_TRY(stp_alloc(&f.tables, cloud->cell_count, sizeof *f.tables, "outliers", err));
    STP_TRY(stp_cloud_run(cloud, pool, cloud->cell_count, find_cell, &f, err));
    STP_TRY(gather_tables(&f, err));
    size_t block_count = ((size_t)f.doubtful.count + BLOCK_ROWS - 1) / BLOCK_ROWS;
    STP_TRY(stp_cloud_run(cloud, pool, block_count, join_block, &f, err));
    *count = 0;
    if (f.any_joined) {
        STP_TRY(decide(&f, err));
        *count = mark(&f);
    }
done:
    for (uint32_t c = 0; f.tables && c < cloud->cell_count; c++)
        table_clear(&f.tables[c], &f);
    table_clear(&f.doubtful, &f);
    free(f.tables);
    stp_spill_free(cloud->spill, (void *)f.states);
    stp_spill_free(cloud->spill, f.spacings);
    return status;
}

/* ---- dropping ---- */

static int compare_sources(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

stp_status stp_outliers_drop(stp_cloud *cloud, uint32_t count, stp_pool *pool, uint32_t **sources,
                             stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *taken = NULL, taken_count = 0, kept = 0;
    STP_TRY(stp_spill_alloc(cloud->spill, &taken, count, sizeof *taken, "outliers", err));
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i)) {
        if (cloud->marks[i] & STP_MARK_OUTLIER)
            taken[taken_count++] = cloud->points[i].source;
        else
            cloud->points[kept++] = cloud->points[i];
    }
    qsort(taken, taken_count, sizeof *taken, compare_sources);
    cloud->count = kept;
    stp_cloud_unsort(cloud);
    STP_TRY(stp_cloud_sort(cloud, pool, err));
    *sources = taken;
    taken = NULL;
done:
    stp_spill_free(cloud->spill, taken);
    return status;
}
