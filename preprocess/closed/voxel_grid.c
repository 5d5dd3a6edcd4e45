/* Flooding by rows of 32 voxels, block by block. */
#include "preprocess/closed/voxel_grid.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

#define BLOCK STP_VOXEL_BLOCK
#define CLAIMED UINT32_MAX

stp_status stp_voxel_grid_create(stp_voxel_grid *out, const int blocks[3], stp_spill *spill,
                                 stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_voxel_grid g = {.blocks = {blocks[0], blocks[1], blocks[2]}, .spill = spill, .pool = pool};
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
    free(grid->places);
    free((void *)grid->reached);
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
    stp_status status = STP_OK;
    const uint32_t count = stp_voxel_grid_claimed(grid);
    STP_TRY(stp_alloc(&grid->places, count, sizeof *grid->places, "a grid", err));
    for (size_t i = 0; i < stp_voxel_place_count(grid); i++)
        if (stp_voxel_number(grid, i) != 0) {
            grid->places[grid->block_count++] = (uint32_t)i;
            atomic_store_explicit(&grid->number[i], grid->block_count, memory_order_relaxed);
        }
    STP_TRY(stp_spill_alloc(grid->spill, &grid->occupied, count, sizeof *grid->occupied, "a grid",
                            err));
    STP_TRY(
        stp_spill_alloc(grid->spill, &grid->outside, count, sizeof *grid->outside, "a grid", err));
done:
    return status;
}

/* ---- passes ---- */

/* Blocks of a task of the pool. */
#define RUN_BLOCKS 16u

typedef struct block_pass {
    const stp_voxel_grid *grid;
    uint32_t count;
    stp_voxel_task *task;
    void *context;
} block_pass;

static stp_status run_blocks(void *context, size_t index, unsigned worker, stp_error *err)
{
    const block_pass *p = context;
    const uint32_t begin = (uint32_t)index * RUN_BLOCKS, left = p->count - begin;
    const uint32_t end = begin + (left < RUN_BLOCKS ? left : RUN_BLOCKS);
    (void)worker;
    (void)err;
    stp_spill_relieve(p->grid->spill);
    for (uint32_t i = begin; i < end; i++)
        p->task(p->context, i);
    return STP_OK;
}

stp_status stp_voxel_grid_run(const stp_voxel_grid *grid, uint32_t count, stp_voxel_task *task,
                              void *context, stp_error *err)
{
    block_pass p = {grid, count, task, context};
    return stp_pool_run(grid->pool, (count + RUN_BLOCKS - 1) / RUN_BLOCKS, run_blocks, &p, err);
}

/* ---- the flood ---- */

/* What a block shows its neighbour: 32 rows of the face between them. */
typedef struct face {
    uint32_t row[BLOCK];
} face;

/* A flood goes in rounds. In each, threads look at places side by side. A place where water may
 * have come in is looked at in the next round. Threads may see water early or late, but what is
 * wet in the end is the same. */
typedef struct flood {
    stp_voxel_grid *grid;
    const stp_voxel_bits *walls;
    uint32_t *queue, *next; /* the places of this round and of the next one, each once */
    _Atomic uint8_t *sides; /* by place: bits of the sides where water may have come in */
    atomic_uint next_count;
} flood;

/* Sides of a block, by axis: low, then high. */
#define SIDES 6
#define ALL_SIDES ((1u << SIDES) - 1)

/* Adds a place to the next round, unless it waits for its turn already. */
static void enqueue(flood *f, size_t place, unsigned sides)
{
    if (atomic_fetch_or_explicit(&f->sides[place], (uint8_t)sides, memory_order_acq_rel) == 0)
        f->next[atomic_fetch_add_explicit(&f->next_count, 1, memory_order_relaxed)] =
            (uint32_t)place;
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

static inline uint32_t row_of(const stp_voxel_bits *b, int z, int y)
{
    return __atomic_load_n(&b->row[z][y], __ATOMIC_RELAXED);
}

/* The set voxels at one side of a block. For a side across x, row z has bit y. */
static face face_of(const stp_voxel_bits *b, int side)
{
    face out = {{0}};
    int last = side % 2 ? BLOCK - 1 : 0;
    for (int i = 0; i < BLOCK; i++) {
        if (side / 2 == 2)
            out.row[i] = row_of(b, last, i);
        else if (side / 2 == 1)
            out.row[i] = row_of(b, i, last);
        else
            for (int y = 0; y < BLOCK; y++)
                out.row[i] |= (row_of(b, i, y) >> last & 1u) << y;
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
    return stp_voxel_reached(g, place) ? all : none;
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

/* Lets water in from a side. Returns whether any is new. */
static bool pour(basin *b, int side, const face *in)
{
    bool came = false;
    int last = side % 2 ? BLOCK - 1 : 0;
    for (int i = 0; i < BLOCK; i++) {
        if (side / 2 == 2)
            came |= wet_row(b, last, i, in->row[i]);
        else if (side / 2 == 1)
            came |= wet_row(b, i, last, in->row[i]);
        else
            for (int y = 0; y < BLOCK; y++)
                came |= wet_row(b, i, y, (in->row[i] >> y & 1u) << last);
    }
    return came;
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
        enqueue(f, next, 1u << (side ^ 1));
}

static void flood_empty(flood *f, size_t place, const int at[3], unsigned sides)
{
    bool comes = false;
    for (int side = 0; side < SIDES && !comes; side++) {
        if (!(sides >> side & 1))
            continue;
        face in = seen_beyond(f, at, side);
        for (int i = 0; i < BLOCK; i++)
            comes |= in.row[i] != 0;
    }
    if (!comes || stp_voxel_reached(f->grid, place))
        return;
    atomic_store_explicit(&f->grid->reached[place], 1, memory_order_relaxed);
    for (int side = 0; side < SIDES; side++)
        enqueue_beyond(f, at, side);
}

/* Writes what is wet. Returns the sides where water is new. */
static unsigned keep_water(stp_voxel_bits *outside, const basin *b)
{
    unsigned sides = 0;
    for (int z = 0; z < BLOCK; z++)
        for (int y = 0; y < BLOCK; y++) {
            const uint32_t fresh = b->wet[z][y] & ~outside->row[z][y];
            if (fresh == 0)
                continue;
            __atomic_store_n(&outside->row[z][y], b->wet[z][y], __ATOMIC_RELAXED);
            sides |= fresh & 1u ? 1u << 0 : 0u;
            sides |= fresh >> (BLOCK - 1) ? 1u << 1 : 0u;
            sides |= y == 0 ? 1u << 2 : y == BLOCK - 1 ? 1u << 3 : 0u;
            sides |= z == 0 ? 1u << 4 : z == BLOCK - 1 ? 1u << 5 : 0u;
        }
    return sides;
}

static void flood_block(flood *f, uint32_t number, const int at[3], unsigned sides)
{
    stp_voxel_bits *outside = &f->grid->outside[number - 1];
    const stp_voxel_bits *walls = &f->walls[number - 1];
    bool came = false;
    basin b;
    memcpy(b.wet, outside->row, sizeof b.wet);
    for (int z = 0; z < BLOCK; z++)
        for (int y = 0; y < BLOCK; y++)
            b.open[z][y] = ~walls->row[z][y];
    for (int side = 0; side < SIDES; side++)
        if (sides >> side & 1) {
            face in = seen_beyond(f, at, side);
            came |= pour(&b, side, &in);
        }
    if (!came)
        return;
    flood_basin(&b);
    sides = keep_water(outside, &b);
    for (int side = 0; side < SIDES; side++)
        if (sides >> side & 1)
            enqueue_beyond(f, at, side);
}

static void look_at_place(void *context, uint32_t index)
{
    flood *f = context;
    const size_t place = f->queue[index];
    const uint32_t number = stp_voxel_number(f->grid, place);
    /* first, so that later water waits for the next round */
    const unsigned sides = atomic_exchange_explicit(&f->sides[place], 0, memory_order_acq_rel);
    int at[3];
    stp_voxel_place_split(f->grid, place, at);
    if (number != 0)
        flood_block(f, number, at, sides);
    else
        flood_empty(f, place, at, sides);
}

static bool on_border(const stp_voxel_grid *g, const int at[3])
{
    for (int i = 0; i < 3; i++)
        if (at[i] == 0 || at[i] + 1 == g->blocks[i])
            return true;
    return false;
}

static void dry_block(void *context, uint32_t block)
{
    const flood *f = context;
    memset(&f->grid->outside[block], 0, sizeof *f->grid->outside);
}

/* Resets: nothing is outside, and every place at the border is queued. */
static stp_status begin_flood(flood *f, stp_error *err)
{
    stp_voxel_grid *g = f->grid;
    memset((void *)g->reached, 0, stp_voxel_place_count(g));
    for (size_t place = 0; place < stp_voxel_place_count(g); place++) {
        int at[3];
        stp_voxel_place_split(g, place, at);
        if (on_border(g, at))
            enqueue(f, place, ALL_SIDES);
    }
    return stp_voxel_grid_run(g, g->block_count, dry_block, f, err);
}

stp_status stp_voxel_grid_flood(stp_voxel_grid *grid, const stp_voxel_bits *walls, stp_error *err)
{
    stp_status status = STP_OK;
    flood f = {.grid = grid, .walls = walls};
    const size_t places = stp_voxel_place_count(grid);
    STP_TRY(stp_alloc(&f.queue, places, sizeof *f.queue, "a grid", err));
    STP_TRY(stp_alloc(&f.next, places, sizeof *f.next, "a grid", err));
    STP_TRY(stp_alloc(&f.sides, places, 1, "a grid", err));
    STP_TRY(begin_flood(&f, err));
    for (uint32_t count; (count = atomic_exchange(&f.next_count, 0)) > 0;) {
        uint32_t *queue = f.next;
        f.next = f.queue;
        f.queue = queue;
        STP_TRY(stp_voxel_grid_run(grid, count, look_at_place, &f, err));
    }
done:
    free((void *)f.sides);
    free(f.next);
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
        return stp_voxel_reached(grid, place) ? STP_VOXEL_OUTSIDE : STP_VOXEL_INSIDE;
    if (grid->occupied[number - 1].row[z % BLOCK][y % BLOCK] & bit)
        return STP_VOXEL_OCCUPIED;
    return grid->outside[number - 1].row[z % BLOCK][y % BLOCK] & bit ? STP_VOXEL_OUTSIDE
                                                                     : STP_VOXEL_INSIDE;
}

bool stp_voxel_grid_clear_of(const stp_voxel_grid *grid, int x, int y, int z, int side)
{
    size_t place = 0;
    uint32_t number = stp_voxel_block_of(grid, x, y, z, &place);
    uint32_t wanted = (side == BLOCK ? UINT32_MAX : (1u << side) - 1) << x % BLOCK;
    if (number == 0)
        return stp_voxel_reached(grid, place);
    for (int k = 0; k < side; k++)
        for (int j = 0; j < side; j++)
            if (~grid->outside[number - 1].row[z % BLOCK + k][y % BLOCK + j] & wanted)
                return false;
    return true;
}
