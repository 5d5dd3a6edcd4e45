/* Seals openings: erodes, floods, and lets outside and inside grow towards each other. */
#include "preprocess/closed/voxel_grid.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

#define BLOCK STP_VOXEL_BLOCK
/* Rounds of growth, one voxel each. Deeper voxels of a crevice stay inside. */
#define ROUNDS 256

/* A set of voxels of the whole grid. Blocks with a number have bits; a block without one is in the
 * set as a whole or not at all. */
typedef struct set {
    const stp_voxel_grid *grid;
    stp_voxel_bits *bits;
    bool reached, unreached; /* blocks without a number that are outside (reached) or not
                                (unreached) are in the set */
    bool beyond;             /* the space beyond the grid is in the set */
} set;

/* The bits of a block. If it has none, returns NULL, and every row of it is *all. */
static inline const stp_voxel_bits *bits_of(const set *s, int x, int y, int z, uint32_t *all)
{
    const stp_voxel_grid *g = s->grid;
    *all = s->beyond ? UINT32_MAX : 0u;
    if (x < 0 || y < 0 || z < 0 || x >= g->blocks[0] || y >= g->blocks[1] || z >= g->blocks[2])
        return NULL;
    const size_t place = stp_voxel_place(g, x, y, z);
    const uint32_t number = stp_voxel_number(g, place);
    if (number != 0)
        return &s->bits[number - 1];
    *all = (g->reached[place] ? s->reached : s->unreached) ? UINT32_MAX : 0u;
    return NULL;
}

/* A block's rows, and those of the blocks before and behind it along an axis. */
typedef struct strip {
    const stp_voxel_bits *bits[3]; /* NULL: the block has none */
    uint32_t all[3];               /* then every row of it */
} strip;

static strip strip_of(const set *s, const int at[3], int axis)
{
    strip out = {{NULL}, {0}};
    for (int i = 0; i < 3; i++) {
        int to[3] = {at[0], at[1], at[2]};
        to[axis] += i - 1;
        out.bits[i] = bits_of(s, to[0], to[1], to[2], &out.all[i]);
    }
    return out;
}

static inline uint32_t strip_row(const strip *s, int block, int z, int y)
{
    return s->bits[block] ? stp_voxel_row(s->bits[block], z, y) : s->all[block];
}

/* A block's rows with those beside it. */
typedef struct shell {
    uint32_t row[BLOCK + 2][BLOCK + 2];                 /* [z + 1][y + 1] */
    uint32_t before[BLOCK][BLOCK], after[BLOCK][BLOCK]; /* of the next blocks along x */
} shell;

static void shell_of(shell *out, const set *s, const int at[3])
{
    const strip x = strip_of(s, at, 0), y = strip_of(s, at, 1), z = strip_of(s, at, 2);
    for (int i = 0; i < BLOCK; i++) {
        for (int j = 0; j < BLOCK; j++) {
            out->row[i + 1][j + 1] = strip_row(&x, 1, i, j);
            out->before[i][j] = strip_row(&x, 0, i, j);
            out->after[i][j] = strip_row(&x, 2, i, j);
        }
        out->row[i + 1][0] = strip_row(&y, 0, i, BLOCK - 1);
        out->row[i + 1][BLOCK + 1] = strip_row(&y, 2, i, 0);
        out->row[0][i + 1] = strip_row(&z, 0, BLOCK - 1, i);
        out->row[BLOCK + 1][i + 1] = strip_row(&z, 2, 0, i);
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
static void widen_rows(const strip *s, int reach, stp_voxel_bits *out)
{
    const int width = 2 * reach + 1;
    for (int z = 0; z < BLOCK; z++)
        for (int y = 0; y < BLOCK; y++) {
            uint64_t row = (uint64_t)strip_row(s, 0, z, y) >> (BLOCK - reach) |
                           (uint64_t)strip_row(s, 1, z, y) << reach |
                           (uint64_t)strip_row(s, 2, z, y) << (BLOCK + reach);
            int done = 1;
            for (; 2 * done <= width; done *= 2)
                row |= row >> done;
            row |= row >> (width - done);
            stp_voxel_row_set(out, z, y, (uint32_t)row);
        }
}

/* Widens a block along y (axis 1) or z (axis 2): joins the rows of the lines along the axis with
 * those farther on, first one, then two, then four. */
static void widen_lines(const strip *s, int axis, int reach, stp_voxel_bits *out)
{
    const int width = 2 * reach + 1, count = BLOCK + 2 * reach;
    uint32_t line[BLOCK + 2 * STP_VOXEL_REACH_MOST][BLOCK] = {{0}};
    for (int i = 0; i < count; i++) {
        const int at = i - reach + BLOCK, block = at / BLOCK, in = at % BLOCK;
        for (int j = 0; j < BLOCK; j++)
            line[i][j] = strip_row(s, block, axis == 2 ? in : j, axis == 2 ? j : in);
    }
    int done = 1;
    for (; 2 * done <= width; done *= 2)
        for (int i = 0; i + done < count; i++)
            for (int j = 0; j < BLOCK; j++)
                line[i][j] |= line[i + done][j];
    for (int i = 0; i < BLOCK; i++)
        for (int j = 0; j < BLOCK; j++)
            stp_voxel_row_set(out, axis == 2 ? i : j, axis == 2 ? j : i,
                              line[i][j] | line[i + width - done][j]);
}

static void remove_rows(stp_voxel_bits *from, const stp_voxel_bits *what)
{
    for (int z = 0; z < BLOCK; z++)
        for (int y = 0; y < BLOCK; y++)
            stp_voxel_row_set(from, z, y, stp_voxel_row(from, z, y) & ~stp_voxel_row(what, z, y));
}

/* Dilates a set by a cube: x into `a`, y into `b`, z into s->bits. If `without` is given, its
 * voxels are removed. */
static void dilate(set *s, int reach, const stp_voxel_bits *without, stp_voxel_bits *a,
                   stp_voxel_bits *b)
{
    const stp_voxel_grid *g = s->grid;
    stp_voxel_bits *const from[3] = {s->bits, a, b}, *const to[3] = {a, b, s->bits};
    for (int axis = 0; axis < 3; axis++) {
        set in = *s;
        in.bits = from[axis];
        for (size_t place = 0; place < stp_voxel_place_count(g); place++) {
            const uint32_t number = stp_voxel_number(g, place);
            int at[3];
            if (number == 0)
                continue;
            stp_voxel_place_split(g, place, at);
            const strip along = strip_of(&in, at, axis);
            if (axis == 0)
                widen_rows(&along, reach, &to[axis][number - 1]);
            else
                widen_lines(&along, axis, reach, &to[axis][number - 1]);
            if (axis == 2 && without)
                remove_rows(&to[axis][number - 1], &without[number - 1]);
        }
    }
}

static void copy(const stp_voxel_grid *g, stp_voxel_bits *to, const stp_voxel_bits *from)
{
    memcpy((void *)to, (const void *)from, g->block_count * sizeof *to);
}

/* Whether the cube fits where the flood does not come. Writes those voxels to `inside`. */
static bool find_rooms(const stp_voxel_grid *g, const stp_voxel_bits *walls, stp_voxel_bits *inside)
{
    bool any = false;
    for (size_t i = 0; i < stp_voxel_place_count(g); i++)
        any |= stp_voxel_number(g, i) == 0 && !g->reached[i];
    for (uint32_t b = 0; b < g->block_count; b++)
        for (int i = 0; i < BLOCK * BLOCK; i++) {
            int z = i / BLOCK, y = i % BLOCK;
            uint32_t row = ~stp_voxel_row(&walls[b], z, y) & ~stp_voxel_row(&g->outside[b], z, y);
            stp_voxel_row_set(&inside[b], z, y, row);
            any |= row != 0;
        }
    return any;
}

/* Outside and inside while they grow towards each other. A round reads the sets as they were before
 * the round. */
typedef struct growth {
    stp_voxel_grid *grid;
    set outer, inner;         /* before the round */
    stp_voxel_bits *inside;   /* the current inside; grid->outside is the current outside */
    uint32_t *places;         /* by number - 1 */
    uint8_t *active, *change; /* by number - 1: may grow in this round; has grown */
} growth;

/* Grows a block by one voxel in all directions through faces. If both reach a voxel, the outside
 * takes it. */
static bool grow_block(growth *w, uint32_t block)
{
    int at[3];
    bool grew = false;
    shell outer, inner;
    stp_voxel_place_split(w->grid, w->places[block], at);
    shell_of(&outer, &w->outer, at);
    shell_of(&inner, &w->inner, at);
    for (int i = 0; i < BLOCK * BLOCK; i++) {
        const int z = i / BLOCK, y = i % BLOCK;
        const uint32_t was_out = outer.row[z + 1][y + 1], was_in = inner.row[z + 1][y + 1];
        const uint32_t open = ~was_out & ~was_in & ~stp_voxel_row(&w->grid->occupied[block], z, y);
        const uint32_t out = spread(&outer, z, y) & open, in = spread(&inner, z, y) & open & ~out;
        if ((out | in) == 0)
            continue;
        stp_voxel_row_set(&w->grid->outside[block], z, y, was_out | out);
        stp_voxel_row_set(&w->inside[block], z, y, was_in | in);
        grew = true;
    }
    return grew;
}

/* Ends a round: takes over what grew. A block that grew, and the blocks around it, may grow in the
 * next round. */
static void end_round(growth *w)
{
    const stp_voxel_grid *g = w->grid;
    memset(w->active, 0, g->block_count);
    for (uint32_t b = 0; b < g->block_count; b++) {
        int at[3];
        if (!w->change[b])
            continue;
        memcpy((void *)&w->outer.bits[b], (void *)&g->outside[b], sizeof g->outside[b]);
        memcpy((void *)&w->inner.bits[b], (void *)&w->inside[b], sizeof w->inside[b]);
        w->active[b] = 1;
        stp_voxel_place_split(g, w->places[b], at);
        for (int side = 0; side < 6; side++) {
            int to[3] = {at[0], at[1], at[2]};
            to[side / 2] += side % 2 ? 1 : -1;
            if (to[side / 2] < 0 || to[side / 2] >= g->blocks[side / 2])
                continue;
            uint32_t number = stp_voxel_number(g, stp_voxel_place(g, to[0], to[1], to[2]));
            if (number != 0)
                w->active[number - 1] = 1;
        }
    }
    memset(w->change, 0, g->block_count);
}

static stp_status grow(stp_voxel_grid *grid, stp_voxel_bits *inside, stp_voxel_bits *a,
                       stp_voxel_bits *b, stp_error *err)
{
    stp_status status = STP_OK;
    growth w = {.grid = grid,
                .outer = {.grid = grid, .bits = a, .reached = true, .beyond = true},
                .inner = {.grid = grid, .bits = b, .unreached = true},
                .inside = inside};
    bool grew = true;
    copy(grid, a, grid->outside);
    copy(grid, b, inside);
    STP_TRY(stp_alloc(&w.places, grid->block_count, sizeof *w.places, "a grid", err));
    STP_TRY(stp_alloc(&w.active, grid->block_count, 1, "a grid", err));
    STP_TRY(stp_alloc(&w.change, grid->block_count, 1, "a grid", err));
    for (size_t i = 0; i < stp_voxel_place_count(grid); i++)
        if (stp_voxel_number(grid, i) != 0)
            w.places[stp_voxel_number(grid, i) - 1] = (uint32_t)i;
    memset(w.active, 1, grid->block_count);
    for (int round = 0; grew && round < ROUNDS; round++) {
        grew = false;
        for (uint32_t block = 0; block < grid->block_count; block++)
            if (w.active[block] && grow_block(&w, block)) {
                w.change[block] = 1;
                grew = true;
            }
        end_round(&w);
    }
done:
    free(w.change);
    free(w.active);
    free(w.places);
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
    copy(grid, walls, grid->occupied);
    dilate(&(set){.grid = grid, .bits = walls}, reach, NULL, inside, a);
    STP_TRY(stp_voxel_grid_flood(grid, walls, err));
    *sealed = find_rooms(grid, walls, inside);
    if (!*sealed)
        goto done;
    set outer = {.grid = grid, .bits = grid->outside, .reached = true, .beyond = true};
    set inner = {.grid = grid, .bits = inside, .unreached = true};
    dilate(&outer, reach, grid->occupied, walls, a);
    dilate(&inner, reach, grid->occupied, walls, a);
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
    for (size_t place = 0; place < stp_voxel_place_count(grid); place++) {
        const uint32_t number = stp_voxel_number(grid, place);
        int at[3];
        shell around;
        if (number == 0)
            continue;
        stp_voxel_place_split(grid, place, at);
        shell_of(&around, &outer, at);
        for (int i = 0; i < BLOCK * BLOCK; i++) {
            const int z = i / BLOCK, y = i % BLOCK;
            const uint32_t open =
                ~around.row[z + 1][y + 1] & ~stp_voxel_row(&grid->occupied[number - 1], z, y);
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
