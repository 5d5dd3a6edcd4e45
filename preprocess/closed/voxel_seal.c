/* Seals openings: erodes, floods, and lets outside and inside grow towards each other. */
#include "preprocess/closed/voxel_grid.h"

#include "base/memory.h"
#include "base/wide.h"

#include <stdlib.h>
#include <string.h>

#define BLOCK STP_VOXEL_BLOCK
/* Rounds of growth, one voxel each. Deeper voxels of a crevice stay inside. */
#define ROUNDS 256

/* What stands for the bits of a block that has none. */
static const stp_voxel_bits none, all = {{[0 ... BLOCK - 1] = {[0 ... BLOCK - 1] = UINT32_MAX}}};

/* A set of voxels of the whole grid. Blocks with a number have bits; a block without one is in the
 * set as a whole or not at all. */
typedef struct set {
    const stp_voxel_grid *grid;
    stp_voxel_bits *bits;
    bool reached, unreached; /* blocks without a number that are outside (reached) or not
                                (unreached) are in the set */
    bool beyond;             /* the space beyond the grid is in the set */
} set;

static const stp_voxel_bits *bits_of(const set *s, int x, int y, int z)
{
    const stp_voxel_grid *g = s->grid;
    if (x < 0 || y < 0 || z < 0 || x >= g->blocks[0] || y >= g->blocks[1] || z >= g->blocks[2])
        return s->beyond ? &all : &none;
    const size_t place = stp_voxel_place(g, x, y, z);
    const uint32_t number = stp_voxel_number(g, place);
    if (number != 0)
        return &s->bits[number - 1];
    return (stp_voxel_reached(g, place) ? s->reached : s->unreached) ? &all : &none;
}

/* A block, and those before and behind it along an axis. */
typedef struct strip {
    const stp_voxel_bits *bits[3];
} strip;

static strip strip_of(const set *s, uint32_t block, int axis)
{
    strip out;
    int at[3];
    stp_voxel_place_split(s->grid, s->grid->places[block], at);
    for (int i = 0; i < 3; i++) {
        int to[3] = {at[0], at[1], at[2]};
        to[axis] += i - 1;
        out.bits[i] = bits_of(s, to[0], to[1], to[2]);
    }
    return out;
}

/* A block's rows with those beside it. */
typedef struct shell {
    uint32_t row[BLOCK + 2][BLOCK + 2];                 /* [z + 1][y + 1] */
    uint32_t before[BLOCK][BLOCK], after[BLOCK][BLOCK]; /* of the next blocks along x */
} shell;

static void shell_of(shell *out, const set *s, uint32_t block)
{
    const strip x = strip_of(s, block, 0), y = strip_of(s, block, 1), z = strip_of(s, block, 2);
    const size_t size = sizeof out->before;
    memcpy(out->before, x.bits[0]->row, size);
    memcpy(out->after, x.bits[2]->row, size);
    for (int i = 0; i < BLOCK; i++) {
        memcpy(&out->row[i + 1][1], x.bits[1]->row[i], sizeof x.bits[1]->row[i]);
        out->row[i + 1][0] = y.bits[0]->row[i][BLOCK - 1];
        out->row[i + 1][BLOCK + 1] = y.bits[2]->row[i][0];
        out->row[0][i + 1] = z.bits[0]->row[BLOCK - 1][i];
        out->row[BLOCK + 1][i + 1] = z.bits[2]->row[0][i];
    }
}

/* The row with the voxels beside its set voxels, in all directions through faces. */
static inline uint32_t spread(const shell *s, int z, int y)
{
    const uint32_t row = s->row[z + 1][y + 1];
    return row | row << 1 | row >> 1 | s->before[z][y] >> (BLOCK - 1) |
           s->after[z][y] << (BLOCK - 1) | s->row[z][y + 1] | s->row[z + 2][y + 1] |
           s->row[z + 1][y] | s->row[z + 1][y + 2];
}

/* Widens a block along x: each row and its ends in one number, joined with itself shifted. */
STP_WIDE
static void widen_rows(const strip *s, int reach, stp_voxel_bits *out)
{
    const int width = 2 * reach + 1;
    for (int z = 0; z < BLOCK; z++)
        for (int y = 0; y < BLOCK; y++) {
            uint64_t row = (uint64_t)s->bits[0]->row[z][y] >> (BLOCK - reach) |
                           (uint64_t)s->bits[1]->row[z][y] << reach |
                           (uint64_t)s->bits[2]->row[z][y] << (BLOCK + reach);
            int done = 1;
            for (; 2 * done <= width; done *= 2)
                row |= row >> done;
            row |= row >> (width - done);
            out->row[z][y] = (uint32_t)row;
        }
}

/* Widens a block along y (axis 1) or z (axis 2): joins the rows of the lines along the axis with
 * those farther on, first one, then two, then four. */
STP_WIDE
static void widen_lines(const strip *s, int axis, int reach, stp_voxel_bits *out)
{
    const int width = 2 * reach + 1, count = BLOCK + 2 * reach;
    uint32_t line[BLOCK + 2 * STP_VOXEL_REACH_MOST][BLOCK] = {{0}};
    for (int i = 0; i < count; i++) {
        const int at = i - reach + BLOCK, in = at % BLOCK;
        const stp_voxel_bits *from = s->bits[at / BLOCK];
        for (int j = 0; j < BLOCK; j++)
            line[i][j] = axis == 2 ? from->row[in][j] : from->row[j][in];
    }
    int done = 1;
    for (; 2 * done <= width; done *= 2)
        for (int i = 0; i + done < count; i++)
            for (int j = 0; j < BLOCK; j++)
                line[i][j] |= line[i + done][j];
    for (int i = 0; i < BLOCK; i++)
        for (int j = 0; j < BLOCK; j++)
            out->row[axis == 2 ? i : j][axis == 2 ? j : i] = line[i][j] | line[i + width - done][j];
}

/* A set on its way to the same one dilated by a cube: along one axis. */
typedef struct dilation {
    set from;
    stp_voxel_bits *to;
    const stp_voxel_bits *without; /* voxels that are removed in the end; NULL: none */
    int axis, reach;
} dilation;

static void dilate_block(void *context, uint32_t block)
{
    const dilation *d = context;
    const strip along = strip_of(&d->from, block, d->axis);
    stp_voxel_bits *out = &d->to[block];
    if (d->axis == 0)
        widen_rows(&along, d->reach, out);
    else
        widen_lines(&along, d->axis, d->reach, out);
    for (int z = 0; d->axis == 2 && d->without && z < BLOCK; z++)
        for (int y = 0; y < BLOCK; y++)
            out->row[z][y] &= ~d->without[block].row[z][y];
}

/* Dilates a set by a cube: x into `a`, y into `b`, z into `to`, which may be the set's bits. If
 * `without` is given, its voxels are removed. */
static stp_status dilate(const set *s, int reach, const stp_voxel_bits *without, stp_voxel_bits *to,
                         stp_voxel_bits *a, stp_voxel_bits *b, stp_error *err)
{
    stp_status status = STP_OK;
    stp_voxel_bits *const steps[4] = {s->bits, a, b, to};
    for (int axis = 0; status == STP_OK && axis < 3; axis++) {
        dilation d = {*s, steps[axis + 1], without, axis, reach};
        d.from.bits = steps[axis];
        status = stp_voxel_grid_run(s->grid, s->grid->block_count, dilate_block, &d, err);
    }
    return status;
}

/* Where the cube fits and the flood does not come. */
typedef struct rooms {
    const stp_voxel_grid *grid;
    const stp_voxel_bits *walls;
    stp_voxel_bits *inside;
    atomic_bool any;
} rooms;

static void find_room(void *context, uint32_t block)
{
    rooms *r = context;
    uint32_t any = 0;
    for (int z = 0; z < BLOCK; z++)
        for (int y = 0; y < BLOCK; y++) {
            const uint32_t row = ~r->walls[block].row[z][y] & ~r->grid->outside[block].row[z][y];
            r->inside[block].row[z][y] = row;
            any |= row;
        }
    if (any)
        atomic_store_explicit(&r->any, true, memory_order_relaxed);
}

/* Writes the voxels of rooms to `inside`. *any: there is a room. */
static stp_status find_rooms(const stp_voxel_grid *g, const stp_voxel_bits *walls,
                             stp_voxel_bits *inside, bool *any, stp_error *err)
{
    rooms r = {.grid = g, .walls = walls, .inside = inside};
    const stp_status status = stp_voxel_grid_run(g, g->block_count, find_room, &r, err);
    *any = atomic_load(&r.any);
    for (size_t i = 0; i < stp_voxel_place_count(g); i++)
        *any |= stp_voxel_number(g, i) == 0 && !stp_voxel_reached(g, i);
    return status;
}

/* Outside and inside while they grow towards each other. A round reads the sets as they were before
 * the round. */
typedef struct growth {
    stp_voxel_grid *grid;
    set outer, inner;         /* before the round */
    stp_voxel_bits *inside;   /* the current inside; grid->outside is the current outside */
    uint8_t *active, *change; /* by number - 1: may grow in this round; has grown in it */
    uint8_t *next;            /* may grow in the next round; threads set it by __atomic_* */
} growth;

/* Grows a block by one voxel in all directions through faces. If both reach a voxel, the outside
 * takes it. Returns the voxels of all rows that are new, joined. */
STP_WIDE
static uint32_t grow_rows(const shell *outer, const shell *inner, const stp_voxel_bits *occupied,
                          stp_voxel_bits *outside, stp_voxel_bits *inside)
{
    uint32_t any = 0;
    for (int z = 0; z < BLOCK; z++)
        for (int y = 0; y < BLOCK; y++) {
            const uint32_t was_out = outer->row[z + 1][y + 1], was_in = inner->row[z + 1][y + 1];
            const uint32_t open = ~was_out & ~was_in & ~occupied->row[z][y];
            const uint32_t out = spread(outer, z, y) & open;
            const uint32_t in = spread(inner, z, y) & open & ~out;
            outside->row[z][y] = was_out | out;
            inside->row[z][y] = was_in | in;
            any |= out | in;
        }
    return any;
}

static void grow_block(void *context, uint32_t block)
{
    const growth *w = context;
    shell outer, inner;
    w->change[block] = 0;
    if (!w->active[block])
        return;
    shell_of(&outer, &w->outer, block);
    shell_of(&inner, &w->inner, block);
    w->change[block] = grow_rows(&outer, &inner, &w->grid->occupied[block],
                                 &w->grid->outside[block], &w->inside[block]) != 0;
}

/* Ends a round: takes over what grew. A block that grew, and the blocks around it, may grow in the
 * next round. */
static void end_round(void *context, uint32_t block)
{
    const growth *w = context;
    const stp_voxel_grid *g = w->grid;
    int at[3];
    if (!w->change[block])
        return;
    memcpy(&w->outer.bits[block], &g->outside[block], sizeof *g->outside);
    memcpy(&w->inner.bits[block], &w->inside[block], sizeof *w->inside);
    __atomic_store_n(&w->next[block], 1, __ATOMIC_RELAXED);
    stp_voxel_place_split(g, g->places[block], at);
    for (int side = 0; side < 6; side++) {
        int to[3] = {at[0], at[1], at[2]};
        to[side / 2] += side % 2 ? 1 : -1;
        if (to[side / 2] < 0 || to[side / 2] >= g->blocks[side / 2])
            continue;
        const uint32_t number = stp_voxel_number(g, stp_voxel_place(g, to[0], to[1], to[2]));
        if (number != 0)
            __atomic_store_n(&w->next[number - 1], 1, __ATOMIC_RELAXED);
    }
}

static void begin_growth(void *context, uint32_t block)
{
    const growth *w = context;
    memcpy(&w->outer.bits[block], &w->grid->outside[block], sizeof *w->outer.bits);
    memcpy(&w->inner.bits[block], &w->inside[block], sizeof *w->inner.bits);
    w->active[block] = 1;
}

static stp_status grow(stp_voxel_grid *grid, stp_voxel_bits *inside, stp_voxel_bits *a,
                       stp_voxel_bits *b, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = grid->block_count;
    growth w = {.grid = grid,
                .outer = {.grid = grid, .bits = a, .reached = true, .beyond = true},
                .inner = {.grid = grid, .bits = b, .unreached = true},
                .inside = inside};
    STP_TRY(stp_alloc(&w.active, count, 1, "a grid", err));
    STP_TRY(stp_alloc(&w.change, count, 1, "a grid", err));
    STP_TRY(stp_alloc(&w.next, count, 1, "a grid", err));
    STP_TRY(stp_voxel_grid_run(grid, count, begin_growth, &w, err));
    for (int round = 0; round < ROUNDS && memchr(w.active, 1, count); round++) {
        STP_TRY(stp_voxel_grid_run(grid, count, grow_block, &w, err));
        STP_TRY(stp_voxel_grid_run(grid, count, end_round, &w, err));
        uint8_t *next = w.next;
        w.next = w.active;
        w.active = next;
        memset(w.next, 0, count);
    }
done:
    free(w.next);
    free(w.change);
    free(w.active);
    return status;
}

stp_status stp_voxel_grid_seal(stp_voxel_grid *grid, int reach, bool *sealed, stp_error *err)
{
    stp_status status = STP_OK;
    stp_voxel_bits *walls = NULL, *inside = NULL, *a = NULL;
    const size_t count = grid->block_count, size = sizeof *walls;
    STP_TRY(stp_spill_alloc(grid->spill, &walls, count, size, "a grid", err));
    STP_TRY(stp_spill_alloc(grid->spill, &inside, count, size, "a grid", err));
    STP_TRY(stp_spill_alloc(grid->spill, &a, count, size, "a grid", err));
    const set occupied = {.grid = grid, .bits = grid->occupied};
    STP_TRY(dilate(&occupied, reach, NULL, walls, inside, a, err));
    STP_TRY(stp_voxel_grid_flood(grid, walls, err));
    STP_TRY(find_rooms(grid, walls, inside, sealed, err));
    if (!*sealed)
        goto done;
    const set outer = {.grid = grid, .bits = grid->outside, .reached = true, .beyond = true};
    const set inner = {.grid = grid, .bits = inside, .unreached = true};
    STP_TRY(dilate(&outer, reach, grid->occupied, grid->outside, walls, a, err));
    STP_TRY(dilate(&inner, reach, grid->occupied, inside, walls, a, err));
    STP_TRY(grow(grid, inside, walls, a, err));
done:
    stp_spill_free(grid->spill, a);
    stp_spill_free(grid->spill, inside);
    stp_spill_free(grid->spill, walls);
    return status;
}

size_t stp_voxel_grid_openings(const stp_voxel_grid *grid, int *out, size_t capacity)
{
    const set outer = {.grid = grid, .bits = grid->outside, .reached = true, .beyond = true};
    size_t count = 0;
    for (uint32_t block = 0; block < grid->block_count; block++) {
        int at[3];
        shell around;
        if (block % 256 == 0)
            stp_spill_relieve(grid->spill);
        stp_voxel_place_split(grid, grid->places[block], at);
        shell_of(&around, &outer, block);
        for (int i = 0; i < BLOCK * BLOCK; i++) {
            const int z = i / BLOCK, y = i % BLOCK;
            const uint32_t open = ~around.row[z + 1][y + 1] & ~grid->occupied[block].row[z][y];
            for (uint32_t row = spread(&around, z, y) & open; row; row &= row - 1, count++)
                if (count < capacity) {
                    out[3 * count] = at[0] * BLOCK + __builtin_ctz(row);
                    out[3 * count + 1] = at[1] * BLOCK + y;
                    out[3 * count + 2] = at[2] * BLOCK + z;
                }
        }
    }
    return count;
}
