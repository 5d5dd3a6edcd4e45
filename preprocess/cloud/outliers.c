/* Finds points, and small groups of points, far from everything else. */
#include "preprocess/cloud/outliers.h"

#include "base/memory.h"
#include "base/sort.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/cloud/cloud_parts.h"
#include "preprocess/cloud/nearest_list.h"
#include "preprocess/cloud/place_list.h"
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
/* A byte has the bits of so many points. */
#define BYTE_POINTS 4u

/* Which neighbours q of a point p are within D times a spacing, bit by bit in the order of the
 * list: min(local(p), local(q)), s(p), local(q). */
typedef struct reach {
    uint64_t step, own, others;
} reach;
_Static_assert(STP_NEIGHBOURS_LIMIT <= 64, "a bit for each neighbour");

/* Neighbour lists of the points in doubt. Duplicates have one row, that of the first. */
typedef struct table {
    uint64_t count;
    uint64_t *points; /* ascending */
    uint64_t *begins; /* of the rows' lists */
    uint8_t *lists;   /* of places, packed (place_list.h) */
    uint64_t list_bytes;
    reach *reaches;
} table;

typedef struct finder {
    stp_cloud *cloud;
    unsigned k;
    double distance; /* in spacings */
    const stp_progress *progress;
    _Atomic(uint8_t) *states; /* of all points, BYTE_POINTS to a byte */
    size_t state_bytes;
    uint8_t *joined;  /* states, of this rank and those before */
    bool *cells_done; /* by cell */
    table *tables;    /* by cell */
    table doubtful;   /* the tables of all cells, on every rank */
    atomic_uint_fast64_t done_count;
    atomic_bool any_joined;
} finder;

static unsigned state_of(const finder *f, uint64_t point)
{
    const uint64_t at = point - f->cloud->first;
    const unsigned byte = atomic_load_explicit(&f->states[at / BYTE_POINTS], memory_order_relaxed);
    return byte >> 2 * (at % BYTE_POINTS) & (JOINED | TOLD);
}

static void add_state(const finder *f, uint64_t point, unsigned bit)
{
    const uint64_t at = point - f->cloud->first;
    if (!(state_of(f, point) & bit)) /* a read is cheaper */
        atomic_fetch_or_explicit(&f->states[at / BYTE_POINTS],
                                 (uint8_t)(bit << 2 * (at % BYTE_POINTS)), memory_order_relaxed);
}

/* Whether two points of a unit are within `distance` times this spacing. */
static bool within(const finder *f, const stp_unit *unit, uint32_t a, uint32_t b, float spacing)
{
    const stp_cloud_point *points = unit->cloud.points;
    stp_dvec3 d = stp_dvec3_sub(points[a].position, points[b].position);
    double most = f->distance * (double)spacing;
    return stp_dvec3_dot(d, d) <= most * most;
}

/* ---- tables ---- */

/* Makes room for the rows but their lists. */
static stp_status table_create(table *t, const finder *f, uint64_t capacity, stp_error *err)
{
    stp_status status = STP_OK;
    stp_spill *spill = f->cloud->spill;
    STP_TRY(stp_spill_alloc(spill, &t->points, capacity, sizeof *t->points, "outliers", err));
    STP_TRY(stp_spill_alloc(spill, &t->begins, capacity, sizeof *t->begins, "outliers", err));
    STP_TRY(stp_spill_alloc(spill, &t->reaches, capacity, sizeof *t->reaches, "outliers", err));
done:
    return status;
}

static void table_clear(table *t, const finder *f)
{
    stp_spill_free(f->cloud->spill, t->points);
    stp_spill_free(f->cloud->spill, t->begins);
    stp_spill_free(f->cloud->spill, t->lists);
    stp_spill_free(f->cloud->spill, t->reaches);
    *t = (table){0};
}

/* The row of a point in doubt. */
static uint64_t row_of(const table *t, uint64_t point)
{
    uint64_t low = 0, high = t->count;
    while (high - low > 1) {
        uint64_t middle = low + (high - low) / 2;
        if (t->points[middle] <= point)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Unpacks a row's list: k places, then STP_PLACE_NONE. */
static void list_of(const finder *f, uint64_t row, uint64_t list[STP_NEIGHBOURS_LIMIT])
{
    const table *t = &f->doubtful;
    (void)stp_place_list_next(t->lists + t->begins[row], t->points[row], f->k, list);
}

/* The rows of a rank, and the bytes of their lists; or where they begin. */
typedef struct table_part {
    uint64_t rows, bytes;
} table_part;

/* Gives a rank's part of the table, from `from` on, to all. */
static stp_status share_part(const finder *f, unsigned rank, table_part from, table_part part,
                             stp_error *err)
{
    stp_status status = STP_OK;
    const table *t = &f->doubtful;
    const uint64_t begin = from.rows, rows = part.rows;
    stp_ranks *ranks = f->cloud->blocks->ranks;
    STP_TRY(stp_ranks_broadcast(ranks, rank, t->points + begin, rows * sizeof *t->points, err));
    STP_TRY(stp_ranks_broadcast(ranks, rank, t->begins + begin, rows * sizeof *t->begins, err));
    STP_TRY(stp_ranks_broadcast(ranks, rank, t->reaches + begin, rows * sizeof *t->reaches, err));
    STP_TRY(stp_ranks_broadcast(ranks, rank, t->lists + from.bytes, part.bytes, err));
done:
    return status;
}

/* Joins the tables of this rank's cells, from a row on. */
static void join_tables(finder *f, table_part from)
{
    const table *all = &f->doubtful;
    for (uint32_t c = 0; c < f->cloud->cell_count; c++) {
        const table *t = &f->tables[c];
        stp_spill_relieve(f->cloud->spill);
        if (t->count > 0) {
            memcpy(all->points + from.rows, t->points, t->count * sizeof *t->points);
            memcpy(all->reaches + from.rows, t->reaches, t->count * sizeof *t->reaches);
            memcpy(all->lists + from.bytes, t->lists, t->list_bytes);
            for (uint64_t i = 0; i < t->count; i++)
                all->begins[from.rows + i] = from.bytes + t->begins[i];
            from.rows += t->count;
            from.bytes += t->list_bytes;
        }
        table_clear(&f->tables[c], f);
    }
}

/* Joins the tables of all cells of all ranks. */
static stp_status gather_tables(finder *f, stp_error *err)
{
    stp_status status = STP_OK;
    table *all = &f->doubtful;
    stp_ranks *ranks = f->cloud->blocks ? f->cloud->blocks->ranks : NULL;
    const unsigned rank_count = stp_ranks_count(ranks);
    table_part own = {0, 0}, at = {0, 0}, *parts = NULL;
    STP_TRY(stp_alloc(&parts, rank_count, sizeof *parts, "ranks", err));
    for (uint32_t c = 0; c < f->cloud->cell_count; c++) {
        own.rows += f->tables[c].count;
        own.bytes += f->tables[c].list_bytes;
    }
    STP_TRY(stp_ranks_gather(ranks, &own, sizeof own, parts, err));
    for (unsigned rank = 0; rank < rank_count; rank++) {
        all->count += parts[rank].rows;
        all->list_bytes += parts[rank].bytes;
    }
    STP_TRY(table_create(all, f, all->count, err));
    STP_TRY(stp_spill_alloc(f->cloud->spill, &all->lists, all->list_bytes, 1, "outliers", err));
    for (unsigned rank = 0; rank < rank_count; rank++) {
        if (!ranks || rank == ranks->self)
            join_tables(f, at);
        if (ranks)
            STP_TRY(share_part(f, rank, at, parts[rank], err));
        at.rows += parts[rank].rows;
        at.bytes += parts[rank].bytes;
    }
done:
    free(parts);
    return status;
}

static void add_own_states(void *context)
{
    const finder *f = context;
    for (size_t i = 0; i < f->state_bytes; i++)
        f->joined[i] |= atomic_load_explicit(&f->states[i], memory_order_relaxed);
}

/* Gives what the ranks know about points to all. */
static stp_status share_states(finder *f, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = f->cloud;
    uint64_t any = atomic_load(&f->any_joined);
    if (!cloud->blocks)
        return STP_OK;
    STP_TRY(stp_cloud_sum(cloud, &any, 1, err));
    atomic_store(&f->any_joined, any > 0);
    STP_TRY(stp_spill_alloc(cloud->spill, &f->joined, f->state_bytes, 1, "outliers", err));
    STP_TRY(stp_cloud_in_turn(cloud, add_own_states, f, f->joined, f->state_bytes, err));
    for (size_t i = 0; i < f->state_bytes; i++)
        atomic_store_explicit(&f->states[i], f->joined[i], memory_order_relaxed);
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
            !within(f, unit, self, list[n], fminf(spacings[self], spacings[list[n]])))
            return false;
    return true;
}

static uint64_t place_of(const stp_unit *unit, uint32_t number)
{
    return number == STP_NEIGHBOUR_NONE ? STP_PLACE_NONE : unit->places[number];
}

static reach reach_of(const finder *f, const stp_unit *unit, const float *spacings, uint32_t self)
{
    reach out = {0};
    const uint32_t *list = unit->neighbours.indices + (size_t)self * f->k;
    for (unsigned n = 0; n < f->k && list[n] != STP_NEIGHBOUR_NONE; n++) {
        const float own = spacings[self], other = spacings[list[n]];
        const uint64_t bit = UINT64_C(1) << n;
        out.step |= within(f, unit, self, list[n], fminf(own, other)) ? bit : 0;
        out.own |= within(f, unit, self, list[n], unit->cloud.points[self].spacing) ? bit : 0;
        out.others |= within(f, unit, self, list[n], other) ? bit : 0;
    }
    return out;
}

/* Packs the lists of the table's rows. */
static stp_status pack_lists(table *t, const finder *f, const stp_unit *unit, stp_error *err)
{
    uint8_t *end = NULL;
    const uint64_t most = t->count * f->k * STP_PLACE_BYTES, first = unit->places[0];
    stp_status status = stp_alloc(&t->lists, most, 1, "outliers", err);
    if (status != STP_OK)
        return status;
    end = t->lists;
    for (uint64_t row = 0; row < t->count; row++) {
        const uint64_t self = t->points[row];
        const uint32_t *list = unit->neighbours.indices + (self - first) * f->k;
        t->begins[row] = (uint64_t)(end - t->lists);
        for (unsigned n = 0; n < f->k; n++)
            end = stp_place_list_write(end, self, place_of(unit, list[n]));
    }
    t->list_bytes = (uint64_t)(end - t->lists);
    return stp_spill_move(f->cloud->spill, &t->lists, t->list_bytes, 1, "outliers", err);
}

/* Splits the cell's points into joined and doubtful ones. The neighbours of joined points are kept,
 * too. */
static stp_status sort_out(finder *f, const stp_unit *unit, const float *spacings, table *doubtful,
                           stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t first = unit->places[0];
    uint32_t count = 0;
    for (uint32_t i = 0; i < unit->ring_end[0]; i++) {
        const uint32_t *list = unit->neighbours.indices + (size_t)i * f->k;
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
        const uint64_t row = doubtful->count++;
        doubtful->points[row] = first + i;
        doubtful->reaches[row] = reach_of(f, unit, spacings, i);
    }
    STP_TRY(pack_lists(doubtful, f, unit, err));
done:
    return status;
}

static uint64_t own_count(const finder *f)
{
    const stp_rank_part own = stp_cloud_own(f->cloud);
    return own.end - own.begin;
}

static stp_status find_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    finder *f = context;
    stp_unit unit = {0};
    float *spacings = NULL;
    bool missed = false;
    stp_cloud seen = *f->cloud;
    seen.missed = &missed;
    (void)worker;
    if (f->cells_done[index])
        return STP_OK;
    STP_TRY(stp_unit_create(&unit, &seen, (uint32_t)index, (uint32_t)index + 1, f->k, RINGS, err));
    if (missed) /* other ranks have points around the cell: they come before the next try */
        goto done;
    uint32_t inner = stp_unit_inner(&unit, 1);
    STP_TRY(stp_alloc(&spacings, inner, sizeof *spacings, "outliers", err));
    for (uint32_t i = 0; i < inner; i++)
        spacings[i] = local_spacing(&unit, i);
    STP_TRY(sort_out(f, &unit, spacings, &f->tables[index], err));
    f->cells_done[index] = true;
    uint64_t done = atomic_fetch_add(&f->done_count, unit.ring_end[0]) + unit.ring_end[0];
    status = stp_progress_update(f->progress, "outliers", done, own_count(f), err);
done:
    free(spacings);
    stp_unit_clear(&unit);
    return status;
}

/* Runs the cells, those again that missed points of other ranks. */
static stp_status find_cells(finder *f, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_rank_part own = stp_cloud_own_cells(f->cloud);
    for (uint64_t left = 1; left > 0;) {
        STP_TRY(stp_cloud_run_own(f->cloud, pool, find_cell, f, err));
        left = 0;
        for (uint64_t c = own.begin; c < own.end; c++)
            left += !f->cells_done[c];
        STP_TRY(stp_cloud_sum(f->cloud, &left, 1, err));
        STP_TRY(stp_cloud_fetch(f->cloud, err));
    }
    stp_cloud_let_go(f->cloud);
done:
    return status;
}

/* ---- the doubtful ones ---- */

static bool among(const uint64_t *points, unsigned count, uint64_t wanted)
{
    for (unsigned i = 0; i < count; i++)
        if (points[i] == wanted)
            return true;
    return false;
}

/* Whether steps reach more than k positions: that many in doubt, or one that is joined. */
static bool joined_with_many(const finder *f, uint64_t row)
{
    const table *t = &f->doubtful;
    uint64_t reached[STP_NEIGHBOURS_LIMIT + 1] = {t->points[row]}, list[STP_NEIGHBOURS_LIMIT];
    unsigned count = 1;
    for (unsigned at = 0; at < count; at++) {
        const uint64_t from = at > 0 ? row_of(t, reached[at]) : row;
        list_of(f, from, list);
        for (unsigned n = 0; n < f->k && list[n] != STP_PLACE_NONE; n++) {
            const uint64_t to = list[n];
            if (!(t->reaches[from].step >> n & 1) || among(reached, count, to))
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
    const uint64_t begin = (uint64_t)block * BLOCK_ROWS, left = f->doubtful.count - begin;
    const uint64_t end = left < BLOCK_ROWS ? begin + left : begin + BLOCK_ROWS;
    (void)worker;
    for (uint64_t row = begin; row < end; row++) {
        if (!joined_with_many(f, row))
            continue;
        add_state(f, f->doubtful.points[row], JOINED);
        atomic_store_explicit(&f->any_joined, true, memory_order_relaxed);
    }
    return stp_progress_update(f->progress, "outliers", own_count(f), own_count(f), err);
}

/* Keeps the neighbours of a kept point within `distance` of its own spacings. */
static void tell_neighbours(const finder *f, uint64_t row)
{
    const table *t = &f->doubtful;
    uint64_t list[STP_NEIGHBOURS_LIMIT];
    list_of(f, row, list);
    for (unsigned n = 0; n < f->k && list[n] != STP_PLACE_NONE; n++)
        if (t->reaches[row].own >> n & 1)
            add_state(f, list[n], TOLD);
}

static bool near_kept(const finder *f, uint64_t row)
{
    const table *t = &f->doubtful;
    uint64_t list[STP_NEIGHBOURS_LIMIT];
    list_of(f, row, list);
    for (unsigned n = 0; n < f->k && list[n] != STP_PLACE_NONE; n++)
        if (state_of(f, list[n]) != 0 && t->reaches[row].others >> n & 1)
            return true;
    return false;
}

/* Repeats rule 2 until nothing changes. */
static stp_status decide(finder *f, stp_error *err)
{
    uint64_t *rows = NULL, count = f->doubtful.count;
    stp_status status =
        stp_spill_alloc(f->cloud->spill, &rows, count, sizeof *rows, "outliers", err);
    for (uint64_t i = 0; status == STP_OK && i < count; i++)
        rows[i] = i;
    for (bool changed = status == STP_OK; changed;) {
        uint64_t left = 0;
        changed = false;
        for (uint64_t i = 0; i < count; i++, stp_cloud_step(f->cloud->spill, i)) {
            const uint64_t point = f->doubtful.points[rows[i]];
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

/* Marks this rank's outliers. Equal positions are on one rank. */
static uint64_t mark(const finder *f)
{
    uint64_t count = 0;
    bool outlier = false;
    const stp_rank_part own = stp_cloud_own(f->cloud);
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(f->cloud->spill, i)) {
        const bool repeats = i > own.begin && stp_cloud_repeats(f->cloud, i);
        outlier = repeats ? outlier : state_of(f, i) == 0;
        f->cloud->marks[i] |= outlier ? STP_MARK_OUTLIER : 0;
        count += outlier;
    }
    return count;
}

stp_status stp_outliers_find(stp_cloud *cloud, unsigned k, double distance, stp_pool *pool,
                             const stp_progress *progress, uint64_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    finder f = {.cloud = cloud,
                .k = k,
                .distance = distance,
                .progress = progress,
                .state_bytes = cloud->count / BYTE_POINTS + 1};
    uint64_t found = 0;
    STP_TRY(stp_spill_alloc(cloud->spill, &f.states, f.state_bytes, 1, "outliers", err));
    STP_TRY(stp_alloc(&f.cells_done, cloud->cell_count, sizeof *f.cells_done, "outliers", err));
    STP_TRY(stp_alloc(&f.tables, cloud->cell_count, sizeof *f.tables, "outliers", err));
    STP_TRY(find_cells(&f, pool, err));
    STP_TRY(gather_tables(&f, err));
    STP_TRY(share_states(&f, err));

    size_t block_count = (f.doubtful.count + BLOCK_ROWS - 1) / BLOCK_ROWS;
    STP_TRY(stp_cloud_run(cloud, pool, block_count, join_block, &f, err));
    if (f.any_joined) {
        STP_TRY(decide(&f, err));
        found = mark(&f);
    }
    STP_TRY(stp_cloud_sum(cloud, &found, 1, err));
    *count = found;
done:
    for (uint32_t c = 0; f.tables && c < cloud->cell_count; c++)
        table_clear(&f.tables[c], &f);
    table_clear(&f.doubtful, &f);
    free(f.tables);
    free(f.cells_done);
    stp_spill_free(cloud->spill, (void *)f.states);
    stp_spill_free(cloud->spill, f.joined);
    return status;
}

/* ---- dropping ---- */

stp_status stp_outliers_drop(stp_cloud *cloud, uint64_t count, stp_pool *pool, uint64_t **sources,
                             uint64_t *source_count, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t *taken = NULL, taken_count = 0, kept = 0;
    const stp_rank_part own = stp_cloud_own(cloud);
    STP_TRY(stp_spill_alloc(cloud->spill, &taken, count, sizeof *taken, "outliers", err));
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i)) {
        if (cloud->marks[i] & STP_MARK_OUTLIER)
            taken[taken_count++] = cloud->points[i].source - cloud->first_record;
        else if (!cloud->blocks)
            cloud->points[cloud->first + kept++] = cloud->points[i];
    }
    stp_sort_u64(taken, taken_count);
    if (cloud->blocks) {
        STP_TRY(stp_cloud_sort_again(cloud, STP_MARK_OUTLIER, pool, err));
    } else {
        cloud->count = kept;
        stp_cloud_unsort(cloud);
        STP_TRY(stp_cloud_sort(cloud, pool, err));
    }
    *sources = taken;
    *source_count = taken_count;
    taken = NULL;
done:
    stp_spill_free(cloud->spill, taken);
    return status;
}
