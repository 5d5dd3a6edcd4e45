/* Trims maps until no two of them lie over each other. */
#include "preprocess/gaps/map_trim.h"

#include "base/memory.h"

#include <stdlib.h>

/* Cells of two maps lie apart by this part of a cell, so that triangles between them are no
 * slivers.
 */
#define TRIM_MARGIN 0.25
/* Cells are of one surface if one's middle is this near to the other's plane, in spacings. */
#define SAME_SURFACE 1.0

/* A cell: its corners in the order of columns, then rows. */
typedef struct cell {
    stp_dvec3 corners[4], middle, normal;
    stp_dbox box;
} cell;

typedef struct trimming {
    stp_map *maps;
    stp_dbox *boxes; /* by map, of its samples */
    uint32_t *order; /* maps, those of most samples first */
    uint32_t *near;  /* earlier maps whose boxes meet the map's */
    uint32_t near_count;
    bool *lost; /* by place of the map's grid: the cell there is to go */
} trimming;

static cell cell_at(const stp_map *map, uint32_t column, uint32_t row)
{
    cell out = {.box = stp_dbox_empty()};
    for (uint32_t k = 0; k < 4; k++) {
        out.corners[k] = stp_map_world(map, column + (k & 1), row + (k >> 1));
        out.middle = stp_dvec3_add(out.middle, stp_dvec3_scale(out.corners[k], 0.25));
        stp_dbox_add(&out.box, out.corners[k]);
    }
    out.normal =
        stp_dvec3_normalize(stp_dvec3_cross(stp_dvec3_sub(out.corners[3], out.corners[0]),
                                            stp_dvec3_sub(out.corners[2], out.corners[1])));
    return out;
}

/* Whether a line along a side of the quadrangle parts it from the box. at: its corners in turn. */
static bool is_beside(double at[4][2], const double low[2], const double high[2])
{
    for (int i = 0; i < 4; i++) {
        const double *a = at[i], *b = at[(i + 1) % 4], *c = at[(i + 2) % 4];
        double n[2] = {b[1] - a[1], a[0] - b[0]};
        if (n[0] * (c[0] - a[0]) + n[1] * (c[1] - a[1]) > 0.0) { /* outwards */
            n[0] = -n[0];
            n[1] = -n[1];
        }
        const double nearest = n[0] * ((n[0] > 0.0 ? low[0] : high[0]) - a[0]) +
                               n[1] * ((n[1] > 0.0 ? low[1] : high[1]) - a[1]);
        if (nearest > 0.0)
            return true;
    }
    return false;
}

/* Whether a map has a cell within the margin of another map's. */
static bool meets(const stp_map *map, const cell *of)
{
    static const int turn[4] = {0, 1, 3, 2};
    const double spacing = map->frame.spacing;
    double at[4][2], low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    if (stp_dvec3_dot(of->normal, map->frame.axes[2]) <= 0.0)
        return false;
    for (int k = 0; k < 4; k++) {
        const stp_dvec3 p = stp_map_frame_local(&map->frame, of->corners[turn[k]]);
        at[k][0] = p.x / spacing;
        at[k][1] = p.y / spacing;
        for (int i = 0; i < 2; i++) {
            low[i] = stp_min(low[i], at[k][i] - TRIM_MARGIN);
            high[i] = stp_max(high[i], at[k][i] + TRIM_MARGIN);
        }
    }
    const double right = stp_min(high[0], map->columns), down = stp_min(high[1], map->rows);
    for (int64_t row = (int64_t)floor(stp_max(low[1], 0.0)); (double)row < down; row++)
        for (int64_t column = (int64_t)floor(stp_max(low[0], 0.0)); (double)column < right;
             column++) {
            const double from[2] = {(double)column - TRIM_MARGIN, (double)row - TRIM_MARGIN};
            const double to[2] = {(double)column + 1.0 + TRIM_MARGIN,
                                  (double)row + 1.0 + TRIM_MARGIN};
            if (!stp_map_is_cell(map, column, row) || is_beside(at, from, to))
                continue;
            const cell own = cell_at(map, (uint32_t)column, (uint32_t)row);
            const stp_dvec3 way = stp_dvec3_sub(of->middle, own.middle);
            if (stp_dvec3_dot(own.normal, of->normal) > 0.0 &&
                fabs(stp_dvec3_dot(way, own.normal)) <= SAME_SURFACE * spacing)
                return true;
        }
    return false;
}

static void lose_sample(stp_map *map, uint32_t column, uint32_t row)
{
    map->samples[(size_t)row * map->columns + column].flags = 0;
    map->count--;
}

/* How many cells around a sample are to stay. */
static unsigned staying(const trimming *t, const stp_map *map, int64_t column, int64_t row)
{
    unsigned count = 0;
    for (int k = 0; k < 4; k++) {
        const int64_t c = column - (k & 1), r = row - (k >> 1);
        count += stp_map_is_cell(map, c, r) && !t->lost[r * map->columns + c];
    }
    return count;
}

/* A cell goes with one of its samples: one with the fewest cells that are to stay. */
static void lose_cells(const trimming *t, stp_map *map)
{
    for (uint32_t row = 0; row + 1 < map->rows; row++)
        for (uint32_t column = 0; column + 1 < map->columns; column++) {
            unsigned least = 5, which = 0;
            if (!t->lost[(size_t)row * map->columns + column] || !stp_map_is_cell(map, column, row))
                continue;
            for (unsigned k = 0; k < 4; k++) {
                const unsigned others = staying(t, map, column + (k & 1), row + (k >> 1));
                which = others < least ? k : which;
                least = others < least ? others : least;
            }
            lose_sample(map, column + (which & 1), row + (which >> 1));
        }
}

/* Takes samples of no cell, and those where cells meet in a point alone. */
static void clean(stp_map *map)
{
    for (bool changed = true; changed;) {
        changed = false;
        for (uint32_t row = 0; row < map->rows; row++)
            for (uint32_t column = 0; column < map->columns; column++) {
                if (!(stp_map_at(map, column, row)->flags & STP_MAP_SUPPORTED))
                    continue;
                const unsigned cells = stp_map_cells_around(map, column, row);
                if (cells != 0 && cells != 5 && cells != 10)
                    continue;
                lose_sample(map, column, row);
                changed = true;
            }
    }
}

static stp_dbox box_of(const stp_map *map)
{
    stp_dbox box = stp_dbox_empty();
    for (uint32_t row = 0; row < map->rows; row++)
        for (uint32_t column = 0; column < map->columns; column++)
            if (stp_map_at(map, column, row)->flags & STP_MAP_SUPPORTED)
                stp_dbox_add(&box, stp_map_world(map, column, row));
    return stp_dbox_grown(&box, map->frame.spacing);
}

/* Marks the cells of a map that lie over those of earlier maps. Returns how many. */
static uint32_t mark_cells(trimming *t, uint32_t index)
{
    const stp_map *map = &t->maps[index];
    uint32_t count = 0;
    for (uint32_t row = 0; row + 1 < map->rows; row++)
        for (uint32_t column = 0; column + 1 < map->columns; column++) {
            bool *lost = &t->lost[(size_t)row * map->columns + column];
            *lost = false;
            if (!stp_map_is_cell(map, column, row))
                continue;
            const cell own = cell_at(map, column, row);
            for (uint32_t k = 0; k < t->near_count && !*lost; k++)
                *lost = stp_dbox_meet(&own.box, &t->boxes[t->near[k]]) &&
                        meets(&t->maps[t->near[k]], &own);
            count += *lost;
        }
    return count;
}

typedef struct rank {
    uint32_t count, map;
} rank;

static int compare_ranks(const void *a, const void *b)
{
    const rank *p = a, *q = b;
    if (p->count != q->count)
        return p->count > q->count ? -1 : 1;
    return (p->map > q->map) - (p->map < q->map);
}

static stp_status order_maps(trimming *t, uint32_t count, size_t *widest, stp_error *err)
{
    stp_status status = STP_OK;
    rank *ranks = NULL;
    STP_TRY(stp_alloc(&ranks, count, sizeof *ranks, "maps", err));
    STP_TRY(stp_alloc(&t->order, count, sizeof *t->order, "maps", err));
    STP_TRY(stp_alloc(&t->near, count, sizeof *t->near, "maps", err));
    STP_TRY(stp_alloc(&t->boxes, count, sizeof *t->boxes, "maps", err));
    *widest = 0;
    for (uint32_t i = 0; i < count; i++) {
        const size_t places = (size_t)t->maps[i].columns * t->maps[i].rows;
        ranks[i] = (rank){t->maps[i].count, i};
        *widest = places > *widest ? places : *widest;
        clean(&t->maps[i]);
        t->boxes[i] = box_of(&t->maps[i]);
    }
    if (count > 0)
        qsort(ranks, count, sizeof *ranks, compare_ranks);
    for (uint32_t i = 0; i < count; i++)
        t->order[i] = ranks[i].map;
done:
    free(ranks);
    return status;
}

stp_status stp_maps_trim(stp_map *maps, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    trimming t = {.maps = maps};
    size_t widest = 0;
    STP_TRY(order_maps(&t, count, &widest, err));
    STP_TRY(stp_alloc(&t.lost, widest, sizeof *t.lost, "maps", err));
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t index = t.order[i];
        t.near_count = 0;
        for (uint32_t k = 0; k < i; k++)
            if (stp_dbox_meet(&t.boxes[index], &t.boxes[t.order[k]]))
                t.near[t.near_count++] = t.order[k];
        if (mark_cells(&t, index) == 0)
            continue;
        lose_cells(&t, &maps[index]);
        clean(&maps[index]);
        t.boxes[index] = box_of(&maps[index]);
    }
done:
    free(t.order);
    free(t.near);
    free(t.boxes);
    free(t.lost);
    return status;
}
