/* Flooding by rows of 32 voxels, block by block. */
#include "preprocess/closed/voxel_grid.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

#define BLOCK STP_VOXEL_BLOCK
#define CLAIMED UINT32_MAX

stp_status stp_voxel_grid_create(stp_voxel_grid *out, const int blocks[3], stp_spill *spill,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    stp_voxel_grid g = {.blocks = {blocks[0], blocks[1], blocks[2]}, .spill = spill};
    STP_TRY(stp_alloc(&g.number, stp_voxel_place_count(&g), sizeof *g.number, "a grid", err));
    STP_TRY(stp_alloc(&g.reached, stp_voxel_place_count(&g), 1, "a grid", err));
    *out = g;
    g = (stp_voxel_grid){0};
done:
    stp_voxel_grid_clear(&g);
    return status;
}

void stp_voxel_grid_clear(stp_voxel_grid *grid)
{
    stp_spill_free(grid->spill, grid->outside);
    stp_spill_free(grid->spill, grid->occupied);
    free(grid->reached);
    free((void *)grid->number);
    *grid = (stp_voxel_grid){0};
}

void stp_voxel_grid_claim(stp_voxel_grid *grid, const int low[3], const int high[3])
{
    int from[3], to[3];
    for (int i = 0; i < 3; i++) {
        from[i] = low[i] < 0 ? 0 : low[i] / BLOCK;
        to[i] = high[i] < 0 ? -1 : high[i] / BLOCK;
        to[i] = to[i] < grid->blocks[i] ? to[i] : grid->blocks[i] - 1;
    }
    for (int z = from[2]; z <= to[2]; z++)
        for (int y = from[1]; y <= to[1]; y++)
            for (int x = from[0]; x <= to[0]; x++)
                atomic_store_explicit(&grid->number[stp_voxel_place(grid, x, y, z)], CLAIMED,
                                      memory_order_relaxed);
}

uint32_t stp_voxel_grid_claimed(const stp_voxel_grid *grid)
{
    uint32_t count = 0;
    for (size_t i = 0; i < stp_voxel_place_count(grid); i++)
        count += stp_voxel_number(grid, i) != 0;
    return count;
}

stp_status stp_voxel_grid_make(stp_voxel_grid *grid, stp_error *err)
{
    for (size_t i = 0; i < stp_voxel_place_count(grid); i++)
        if (stp_voxel_number(grid, i) != 0)
            atomic_store_explicit(&grid->number[i], ++grid->block_count, memory_order_relaxed);
    stp_status status = stp_spill_alloc(grid->spill, &grid->occupied, grid->block_count,
                                        sizeof *grid->occupied, "a grid", err);
    if (status != STP_OK)
        return status;
    return stp_spill_alloc(grid->spill, &grid->outside, grid->block_count, sizeof *grid->outside,
                           "a grid", err);
}

/* ---- the flood ---- */

/* What a block shows its neighbour: 32 rows of the face between them. */
typedef struct face {
    uint32_t row[BLOCK];
} face;

/* The queue of places to look at: a ring with each place at most once. */
typedef struct flood {
    stp_voxel_grid *grid;
    const stp_voxel_bits *walls;
    uint32_t *queue;
    uint8_t *queued;
    size_t capacity, begin, count;
} flood;

/* Sides of a block, by axis: low, then high. */
#define SIDES 6

static void enqueue(flood *f, size_t place)
{
    if (f->queued[place])
        return;
    f->queued[place] = 1;
    f->queue[(f->begin + f->count++) % f->capacity] = (uint32_t)place;
}

/* The place beyond a side of a block. False: beyond the grid. */
static bool beyond(const stp_voxel_grid *g, const int at[3], int side, size_t *place)
{
    int to[3] = {at[0], at[1], at[2]};
    to[side / 2] += side % 2 ? 1 : -1;
    if (to[side / 2] < 0 || to[side / 2] >= g->blocks[side / 2])
        return false;
    *place = stp_voxel_place(g, to[0], to[1], to[2]);
    return true;
}

/* The set voxels at one side of a block. For a side across x, row z has bit y. */
static face face_of(const stp_voxel_bits *b, int side)
{
    face out = {{0}};
    int last = side % 2 ? BLOCK - 1 : 0;
    for (int i = 0; i < BLOCK; i++) {
        if (side / 2 == 2)
            out.row[i] = stp_voxel_row(b, last, i);
        else if (side / 2 == 1)
            out.row[i] = stp_voxel_row(b, i, last);
        else
            for (int y = 0; y < BLOCK; y++)
                out.row[i] |= (stp_voxel_row(b, i, y) >> last & 1u) << y;
    }
    return out;
}

/* The outside voxels beyond one side of a block. */
static face seen_beyond(const flood *f, const int at[3], int side)
{
    const stp_voxel_grid *g = f->grid;
    face all, none = {{0}};
    size_t place = 0;
    memset(&all, 0xff, sizeof all);
    if (!beyond(g, at, side, &place))
        return all;
    uint32_t number = stp_voxel_number(g, place);
    if (number != 0)
        return face_of(&g->outside[number - 1], side ^ 1);
    return g->reached[place] ? all : none;
}

/* A block during its flood. */
typedef struct basin {
    uint32_t wet[BLOCK][BLOCK], open[BLOCK][BLOCK];
} basin;

/* Grows set bits along runs of open ones (Kogge and Stone 1973, both ways). */
static uint32_t fill_row(uint32_t set, uint32_t open)
{
    uint32_t up = open, down = open;
    for (int step = 1; step < BLOCK; step *= 2) {
        set |= up & set << step;
        up &= up << step;
        set |= down & set >> step;
        down &= down >> step;
    }
    return set;
}

/* Lets water into a row whose water fills its runs already. Returns whether any is new. */
static inline bool wet_row(basin *b, int z, int y, uint32_t water)
{
    const uint32_t open = b->open[z][y], set = b->wet[z][y] | (water & open);
    if (set == b->wet[z][y])
        return false;
    b->wet[z][y] = fill_row(set, open);
    return true;
}

static void pour(basin *b, int side, const face *in)
{
    int last = side % 2 ? BLOCK - 1 : 0;
    for (int i = 0; i < BLOCK; i++) {
        if (side / 2 == 2)
            wet_row(b, last, i, in->row[i]);
        else if (side / 2 == 1)
            wet_row(b, i, last, in->row[i]);
        else
            for (int y = 0; y < BLOCK; y++)
                wet_row(b, i, y, (in->row[i] >> y & 1u) << last);
    }
}

/* Grows one row from its neighbours in the block. Returns whether it grew. */
static bool grow_row(basin *b, int z, int y)
{
    uint32_t water = 0;
    water |= y > 0 ? b->wet[z][y - 1] : 0u;
    water |= y + 1 < BLOCK ? b->wet[z][y + 1] : 0u;
    water |= z > 0 ? b->wet[z - 1][y] : 0u;
    water |= z + 1 < BLOCK ? b->wet[z + 1][y] : 0u;
    return wet_row(b, z, y, water);
}

/* Sweeps forth and back until nothing grows. */
static void flood_basin(basin *b)
{
    for (bool grew = true; grew;) {
        grew = false;
        for (int i = 0; i < BLOCK * BLOCK; i++)
            grew |= grow_row(b, i / BLOCK, i % BLOCK);
        for (int i = BLOCK * BLOCK - 1; grew && i >= 0; i--)
            grow_row(b, i / BLOCK, i % BLOCK);
    }
}

static void enqueue_beyond(flood *f, const int at[3], int side)
{
    size_t next = 0;
    if (beyond(f->grid, at, side, &next))
        enqueue(f, next);
}

static void flood_empty(flood *f, size_t place, const int at[3])
{
    bool comes = false;
    for (int side = 0; side < SIDES && !comes; side++) {
        face in = seen_beyond(f, at, side);
        for (int i = 0; i < BLOCK; i++)
            comes |= in.row[i] != 0;
    }
    if (!comes || f->grid->reached[place])
        return;
    f->grid->reached[place] = 1;
    for (int side = 0; side < SIDES; side++)
        enqueue_beyond(f, at, side);
}

static void flood_block(flood *f, uint32_t number, const int at[3])
{
    stp_voxel_bits *outside = &f->grid->outside[number - 1];
    basin b;
    face before[SIDES];
    for (int i = 0; i < BLOCK * BLOCK; i++) {
        b.wet[i / BLOCK][i % BLOCK] = stp_voxel_row(outside, i / BLOCK, i % BLOCK);
        b.open[i / BLOCK][i % BLOCK] = ~stp_voxel_row(&f->walls[number - 1], i / BLOCK, i % BLOCK);
    }
    for (int side = 0; side < SIDES; side++) {
        face in = seen_beyond(f, at, side);
        before[side] = face_of(outside, side);
        pour(&b, side, &in);
    }
    flood_basin(&b);
    for (int i = 0; i < BLOCK * BLOCK; i++)
        stp_voxel_row_set(outside, i / BLOCK, i % BLOCK, b.wet[i / BLOCK][i % BLOCK]);
    for (int side = 0; side < SIDES; side++) {
        face after = face_of(outside, side);
        if (memcmp(&before[side], &after, sizeof after) != 0)
            enqueue_beyond(f, at, side);
    }
}

static bool on_border(const stp_voxel_grid *g, const int at[3])
{
    for (int i = 0; i < 3; i++)
        if (at[i] == 0 || at[i] + 1 == g->blocks[i])
            return true;
    return false;
}

/* Resets: nothing is outside, and every place at the border is queued. */
static void begin_flood(flood *f)
{
    stp_voxel_grid *g = f->grid;
    memset(g->reached, 0, f->capacity);
    for (uint32_t i = 0; i < g->block_count; i++)
        memset((void *)&g->outside[i], 0, sizeof g->outside[i]);
    for (size_t place = 0; place < f->capacity; place++) {
        int at[3];
        stp_voxel_place_split(g, place, at);
        if (on_border(g, at))
            enqueue(f, place);
    }
}

stp_status stp_voxel_grid_flood(stp_voxel_grid *grid, const stp_voxel_bits *walls, stp_error *err)
{
    stp_status status = STP_OK;
    flood f = {.grid = grid, .walls = walls, .capacity = stp_voxel_place_count(grid)};
    STP_TRY(stp_alloc(&f.queue, f.capacity, sizeof *f.queue, "a grid", err));
    STP_TRY(stp_alloc(&f.queued, f.capacity, 1, "a grid", err));
    begin_flood(&f);
    while (f.count > 0) {
        int at[3];
        size_t place = f.queue[f.begin];
        f.begin = (f.begin + 1) % f.capacity;
        f.count--;
        f.queued[place] = 0;
        stp_voxel_place_split(grid, place, at);
        uint32_t number = stp_voxel_number(grid, place);
        if (number != 0)
            flood_block(&f, number, at);
        else
            flood_empty(&f, place, at);
    }
done:
    free(f.queued);
    free(f.queue);
    return status;
}

/* ---- what was found ---- */

stp_voxel stp_voxel_grid_at(const stp_voxel_grid *grid, int x, int y, int z)
{
    size_t place = 0;
    if (stp_voxel_beyond(grid, x, y, z))
        return STP_VOXEL_OUTSIDE;
    uint32_t number = stp_voxel_block_of(grid, x, y, z, &place), bit = 1u << (x % BLOCK);
    if (number == 0)
        return grid->reached[place] ? STP_VOXEL_OUTSIDE : STP_VOXEL_INSIDE;
    if (stp_voxel_row(&grid->occupied[number - 1], z % BLOCK, y % BLOCK) & bit)
        return STP_VOXEL_OCCUPIED;
    return stp_voxel_row(&grid->outside[number - 1], z % BLOCK, y % BLOCK) & bit ? STP_VOXEL_OUTSIDE
                                                                                 : STP_VOXEL_INSIDE;
}

bool stp_voxel_grid_clear_of(const stp_voxel_grid *grid, int x, int y, int z, int side)
{
    size_t place = 0;
    uint32_t number = stp_voxel_block_of(grid, x, y, z, &place);
    uint32_t wanted = (side == BLOCK ? UINT32_MAX : (1u << side) - 1) << x % BLOCK;
    if (number == 0)
        return grid->reached[place];
    for (int k = 0; k < side; k++)
        for (int j = 0; j < side; j++)
            if (~stp_voxel_row(&grid->outside[number - 1], z % BLOCK + k, y % BLOCK + j) & wanted)
                return false;
    return true;
}
