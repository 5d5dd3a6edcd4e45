/* Discs in hashed cells. */
#include "formats/chunk/disc_grid.h"

#include "base/memory.h"
#include "formats/chunk/patch_bounds.h"

#include <stdlib.h>
#include <string.h>

/* A cell is so many mean radii wide. */
#define CELL_RADII 2.0
/* A disc that reaches farther than so many cells from its centre's is large. */
#define REACH_CELLS 4
/* A point looks no farther than so many cells, and at no more discs than this. */
#define RING_MAX 2
#define TRIES_MAX 1024
#define CELLS_MAX 4e15
/* A search within the hint's squared distance finds the hint at least, in spite of its floats. */
#define HINT_SLACK 1.0001

typedef struct cell {
    int64_t at[3];
} cell;

/* Blocks of 4 x 4 x 4 cells are hashed; the cells of a block lie together. */
static uint32_t bucket_of(const stp_disc_grid *g, int64_t i, int64_t j, int64_t k)
{
    uint64_t h = (uint64_t)(i >> 2) * 0x9e3779b97f4a7c15u ^
                 (uint64_t)(j >> 2) * 0xc2b2ae3d27d4eb4fu ^
                 (uint64_t)(k >> 2) * 0x165667b19e3779f9u;
    uint32_t block = (uint32_t)(h >> 32 ^ h) & g->mask;
    return block << 6 | (uint32_t)((i & 3) << 4 | (j & 3) << 2 | (k & 3));
}

/* Farther out than doubles count whole cells, all is one cell. */
static int64_t step_of(double cells)
{
    return (int64_t)stp_max(-CELLS_MAX, stp_min(CELLS_MAX, floor(cells)));
}

static cell cell_of(const stp_disc_grid *g, stp_dvec3 p)
{
    return (cell){{step_of(p.x / g->width), step_of(p.y / g->width), step_of(p.z / g->width)}};
}

/* Cells are as wide as the chunk's own discs ask: the geometric mean keeps a few large discs from
 * making the cells of many small ones wide. */
static void fill_discs(stp_disc_grid *g, const stp_chunk *chunk, const stp_surroundings *around)
{
    double sum = 0.0;
    uint32_t wide = 0;
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++) {
            stp_flat_disc *disc = &g->discs[i];
            *disc = stp_flat_disc_from_sample(&chunk->samples[0][i], &chunk->patches[p]);
            if (disc->radius > 0.0) {
                sum += log(disc->radius);
                wide++;
            }
        }
    g->width = wide ? CELL_RADII * exp(sum / wide) : 1.0;
    if (around && around->count > 0)
        memcpy(g->discs + g->own_count, around->discs, around->count * sizeof *g->discs);
}

/* Half the box of a disc; of a ball its radius. */
static stp_dvec3 half_box(const stp_flat_disc *d)
{
    stp_dvec3 n = d->normal;
    return (stp_dvec3){d->radius * sqrt(stp_max(0.0, 1.0 - n.x * n.x)),
                       d->radius * sqrt(stp_max(0.0, 1.0 - n.y * n.y)),
                       d->radius * sqrt(stp_max(0.0, 1.0 - n.z * n.z))};
}

/* The cells that the disc's box touches; false if it is large. */
static bool cells_of_disc(const stp_disc_grid *g, const stp_flat_disc *d, cell *low, cell *high)
{
    stp_dvec3 half = half_box(d);
    double reach = REACH_CELLS * g->width;
    *low = cell_of(g, stp_dvec3_sub(d->centre, half));
    *high = cell_of(g, stp_dvec3_add(d->centre, half));
    return half.x <= reach && half.y <= reach && half.z <= reach;
}

static void note_large(stp_disc_grid *g, uint32_t disc)
{
    if (g->large_count < STP_DISC_LARGE_MAX)
        g->large[g->large_count] = disc;
    g->large_count++;
}

static void enter(stp_disc_grid *g, uint32_t entry, uint32_t disc)
{
    const stp_flat_disc *d = &g->discs[disc];
    float *const *column = g->columns.of;
    column[0][entry] = (float)d->centre.x;
    column[1][entry] = (float)d->centre.y;
    column[2][entry] = (float)d->centre.z;
    column[3][entry] = (float)d->normal.x;
    column[4][entry] = (float)d->normal.y;
    column[5][entry] = (float)d->normal.z;
    column[6][entry] = (float)d->radius;
    g->disc_of_entry[entry] = disc;
}

/* Counts each disc's entries in begin and notes the large ones, or, once there is room for entries,
 * writes them before begin. */
static void enter_discs(stp_disc_grid *g)
{
    for (uint32_t d = g->count; d-- > 0;) {
        cell low, high;
        if (!cells_of_disc(g, &g->discs[d], &low, &high)) {
            if (!g->disc_of_entry)
                note_large(g, d);
            continue;
        }
        for (int64_t i = low.at[0]; i <= high.at[0]; i++)
            for (int64_t j = low.at[1]; j <= high.at[1]; j++)
                for (int64_t k = low.at[2]; k <= high.at[2]; k++) {
                    uint32_t *begin = &g->begin[bucket_of(g, i, j, k)];
                    if (g->disc_of_entry)
                        enter(g, --*begin, d);
                    else
                        ++*begin;
                }
    }
}

stp_status stp_disc_grid_create(stp_disc_grid *out, const stp_chunk *chunk,
                                const stp_surroundings *around, stp_error *err)
{
    stp_status status = STP_OK;
    stp_disc_grid g = {.own_count = chunk->level_begin[0][chunk->patch_count]};
    g.count = g.own_count + (around ? around->count : 0);
    uint32_t size = 1, sum = 0;
    while (8 * size < g.count)
        size *= 2;
    g.mask = size - 1;
    size *= 64;
    STP_TRY(stp_alloc(&g.discs, g.count, sizeof *g.discs, "discs", err));
    STP_TRY(stp_alloc(&g.begin, (size_t)size + 1, sizeof *g.begin, "discs", err));
    fill_discs(&g, chunk, around);
    enter_discs(&g);
    for (uint32_t b = 0; b <= size; b++)
        g.begin[b] = sum += g.begin[b];
    STP_TRY(stp_disc_columns_create(&g.columns, sum, err));
    STP_TRY(stp_alloc(&g.disc_of_entry, (size_t)sum + 1, sizeof *g.disc_of_entry, "discs", err));
    enter_discs(&g);
done:
    if (status != STP_OK)
        stp_disc_grid_clear(&g);
    *out = g;
    return status;
}

void stp_disc_grid_clear(stp_disc_grid *g)
{
    stp_disc_columns_clear(&g->columns);
    free(g->discs);
    free(g->begin);
    free(g->disc_of_entry);
    *g = (stp_disc_grid){0};
}

stp_disc_position stp_disc_grid_position(const stp_disc_grid *grid, uint32_t disc, stp_dvec3 x)
{
    const stp_flat_disc *d = &grid->discs[disc];
    stp_dvec3 v = stp_dvec3_sub(x, d->centre);
    double height = stp_dvec3_dot(v, d->normal);
    double across = sqrt(stp_max(0.0, stp_dvec3_dot(v, v) - height * height));
    double overhang = stp_max(0.0, across - d->radius);
    return (stp_disc_position){disc, height * height + overhang * overhang, fabs(height), overhang};
}

/* A point's search. */
typedef struct search {
    const stp_disc_grid *grid;
    float x[3];
    float enough;
    uint32_t tries; /* left */
    float squared;  /* distance of the nearest so far */
    uint32_t entry; /* of it, UINT32_MAX for what was given */
} search;

static bool has_ended(const search *s)
{
    return s->tries == 0 || s->squared <= s->enough;
}

static void try_cell(search *s, int64_t i, int64_t j, int64_t k)
{
    const stp_disc_grid *g = s->grid;
    uint32_t bucket = bucket_of(g, i, j, k);
    uint32_t begin = g->begin[bucket], count = g->begin[bucket + 1] - begin;
    count = count < s->tries ? count : s->tries;
    s->tries -= count;
    uint32_t entry = stp_disc_columns_nearest(&g->columns, begin, count, s->x, &s->squared);
    if (entry != UINT32_MAX)
        s->entry = entry;
}

/* From a place in its cell to the cell `steps` beside it, along one axis. */
static double axis_distance(double in, int steps, double width)
{
    return steps < 0 ? in - (steps + 1) * width : steps > 0 ? steps * width - in : 0.0;
}

/* The cells whose greatest step from the middle is `ring`, where they come nearer than the best. */
static void try_ring(search *s, const cell *middle, const double in[3], int ring)
{
    double width = s->grid->width, x[3];
    for (int i = -ring; i <= ring; i++) {
        x[0] = axis_distance(in[0], i, width);
        for (int j = -ring; j <= ring; j++) {
            bool side = abs(i) == ring || abs(j) == ring;
            x[1] = axis_distance(in[1], j, width);
            for (int k = -ring; k <= ring; k += side || ring == 0 ? 1 : 2 * ring) {
                x[2] = axis_distance(in[2], k, width);
                if (has_ended(s))
                    return;
                if (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] < (double)s->squared)
                    try_cell(s, middle->at[0] + i, middle->at[1] + j, middle->at[2] + k);
            }
        }
    }
}

/* The cells around x. True if the best is the nearest of all that are entered, or near enough. */
static bool try_cells(search *s, stp_dvec3 x)
{
    double width = s->grid->width;
    cell middle = cell_of(s->grid, x);
    double in[3] = {x.x - (double)middle.at[0] * width, x.y - (double)middle.at[1] * width,
                    x.z - (double)middle.at[2] * width};
    double room = INFINITY; /* to the nearest face of the cell */
    for (int a = 0; a < 3; a++)
        room = stp_min(room, stp_min(in[a], width - in[a]));
    for (int ring = 0; ring <= RING_MAX && !has_ended(s); ring++) {
        double seen = room + ring * width;
        try_ring(s, &middle, in, ring);
        if ((double)s->squared <= seen * seen)
            return true;
    }
    return s->squared <= s->enough;
}

/* Searches what is nearer than `within`, squared. */
static bool search_within(const stp_disc_grid *grid, stp_dvec3 x, double enough, double within,
                          uint32_t *entry)
{
    search s = {.grid = grid,
                .x = {(float)x.x, (float)x.y, (float)x.z},
                .enough = (float)enough,
                .tries = TRIES_MAX,
                .squared = (float)within,
                .entry = UINT32_MAX};
    bool found = try_cells(&s, x);
    *entry = s.entry;
    return found;
}

bool stp_disc_grid_nearest(const stp_disc_grid *grid, stp_dvec3 x, double enough, uint32_t hint,
                           stp_disc_position *best)
{
    uint32_t entry = UINT32_MAX;
    if (grid->large_count > STP_DISC_LARGE_MAX)
        return false;
    for (uint32_t i = 0; i < grid->large_count; i++) {
        stp_disc_position large = stp_disc_grid_position(grid, grid->large[i], x);
        if (large.squared < best->squared)
            *best = large;
    }
    stp_disc_position hinted = stp_disc_grid_position(grid, hint, x);
    if (hinted.squared <= enough) {
        *best = hinted;
        return true;
    }
    double within = hinted.squared * HINT_SLACK;
    bool found = within < best->squared && search_within(grid, x, enough, within, &entry);
    if (entry == UINT32_MAX) /* no hint, or its float lies */
        found = search_within(grid, x, enough, best->squared, &entry);
    if (entry != UINT32_MAX)
        *best = stp_disc_grid_position(grid, grid->disc_of_entry[entry], x);
    return found;
}
