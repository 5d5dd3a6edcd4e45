/* A grid of voxels. Some are occupied; each of the others is outside or inside.
 *
 * Voxels are bits in blocks of 32 x 32 x 32. A block that nobody claims takes five bytes.
 * Everything beyond the grid is outside. Units: voxels; voxel (i, j, k) is the cube from (i, j, k)
 * to (i + 1, j + 1, k + 1). Threads: claims and marks from any thread; everything else from one,
 * which lets those of a pool flood and seal. The result is the same for any number of them. */
#ifndef STP_PREPROCESS_CLOSED_VOXEL_GRID_H
#define STP_PREPROCESS_CLOSED_VOXEL_GRID_H

#include "base/pool.h"
#include "base/spill.h"

#include <stdatomic.h>
#include <stdbool.h>

#define STP_VOXEL_BLOCK 32
/* Most that stp_voxel_grid_seal reaches. */
#define STP_VOXEL_REACH_MOST 5
/* Most blocks along an axis. */
#define STP_VOXEL_BLOCKS_LIMIT 128

/* A bit for each voxel of a block: [z][y], bit x. Plain numbers, so that loops over rows go in
 * lanes; where threads meet, __atomic_* reads and writes them. */
typedef struct stp_voxel_bits {
    uint32_t row[STP_VOXEL_BLOCK][STP_VOXEL_BLOCK];
} stp_voxel_bits;

typedef struct stp_voxel_grid {
    int blocks[3];                      /* along each axis */
    _Atomic uint32_t *number;           /* by place: the block's number from 1; 0: no block */
    _Atomic uint8_t *reached;           /* by place: the block has no number and is outside */
    uint32_t *places;                   /* by number - 1 */
    stp_voxel_bits *occupied, *outside; /* by number - 1 */
    uint32_t block_count;               /* blocks with a number */
    stp_spill *spill;                   /* where blocks lie, borrowed */
    stp_pool *pool;                     /* borrowed */
} stp_voxel_grid;

/* Creates a grid of this many blocks along each axis, 1 to the limit. No block is claimed. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_voxel_grid_create(stp_voxel_grid *out, const int blocks[3], stp_spill *spill,
                                 stp_pool *pool, stp_error *err);
void stp_voxel_grid_clear(stp_voxel_grid *grid);

/* Claims the blocks of a box of voxels, ends included: its voxels may be occupied later. Voxels
 * beyond the grid are ignored. */
void stp_voxel_grid_claim(stp_voxel_grid *grid, const int low[3], const int high[3]);
/* How many blocks are claimed. */
uint32_t stp_voxel_grid_claimed(const stp_voxel_grid *grid);
/* Makes the claimed blocks. After this, claim no more. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_voxel_grid_make(stp_voxel_grid *grid, stp_error *err);

/* Floods the grid from beyond it: a voxel is outside if a path through faces of voxels that are not
 * in `walls` joins it to beyond the grid. walls: by number - 1; blocks that nobody claimed have no
 * walls. Errors: OUT_OF_MEMORY. */
stp_status stp_voxel_grid_flood(stp_voxel_grid *grid, const stp_voxel_bits *walls, stp_error *err);

/* Floods with a cube of 2 reach + 1 voxels on a side instead of a single voxel.
 * 1. The cube moves in from beyond the grid and touches no occupied voxel. Voxels that it covers
 *    are outside.
 * 2. Other places where the cube fits are rooms. Voxels that a room's cube covers are inside.
 * 3. Outside and inside grow towards each other, one voxel a round, into the open voxels left. Each
 *    of these joins the nearer of the two.
 *
 * So the outside ends in every opening that is narrower than the cube, if there is a room behind
 * it. reach: 1 to STP_VOXEL_REACH_MOST. Claim blocks up to `reach` voxels around occupied voxels.
 * *sealed: there is a room. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_voxel_grid_seal(stp_voxel_grid *grid, int reach, bool *sealed, stp_error *err);

typedef enum stp_voxel { STP_VOXEL_INSIDE, STP_VOXEL_OUTSIDE, STP_VOXEL_OCCUPIED } stp_voxel;

/* What a voxel is, after a flood. */
stp_voxel stp_voxel_grid_at(const stp_voxel_grid *grid, int x, int y, int z);
/* Whether all voxels of a cube are outside. side: a power of two, at most 32, that divides x, y and
 * z. */
bool stp_voxel_grid_clear_of(const stp_voxel_grid *grid, int x, int y, int z, int side);
/* Finds where inside and outside meet after a seal: inside voxels beside an outside voxel. Writes
 * three numbers each for up to `capacity` of them. Returns how many there are. */
size_t stp_voxel_grid_openings(const stp_voxel_grid *grid, int *out, size_t capacity);

/* ---- for passes over all blocks ---- */

typedef void stp_voxel_task(void *context, uint32_t index);
/* Calls task for each index below count, on the pool. Keeps to the spill's limit of memory. */
stp_status stp_voxel_grid_run(const stp_voxel_grid *grid, uint32_t count, stp_voxel_task *task,
                              void *context, stp_error *err);

static inline size_t stp_voxel_place_count(const stp_voxel_grid *g)
{
    return (size_t)g->blocks[0] * (size_t)g->blocks[1] * (size_t)g->blocks[2];
}

static inline size_t stp_voxel_place(const stp_voxel_grid *g, int x, int y, int z)
{
    return ((size_t)z * (size_t)g->blocks[1] + (size_t)y) * (size_t)g->blocks[0] + (size_t)x;
}

static inline uint32_t stp_voxel_number(const stp_voxel_grid *g, size_t place)
{
    return atomic_load_explicit(&g->number[place], memory_order_relaxed);
}

static inline bool stp_voxel_reached(const stp_voxel_grid *g, size_t place)
{
    return atomic_load_explicit(&g->reached[place], memory_order_relaxed) != 0;
}

/* Splits a place into its block coordinates. */
static inline void stp_voxel_place_split(const stp_voxel_grid *g, size_t place, int at[3])
{
    at[0] = (int)(place % (size_t)g->blocks[0]);
    at[1] = (int)(place / (size_t)g->blocks[0] % (size_t)g->blocks[1]);
    at[2] = (int)(place / (size_t)g->blocks[0] / (size_t)g->blocks[1]);
}

static inline bool stp_voxel_beyond(const stp_voxel_grid *g, int x, int y, int z)
{
    return x < 0 || y < 0 || z < 0 || x >= g->blocks[0] * STP_VOXEL_BLOCK ||
           y >= g->blocks[1] * STP_VOXEL_BLOCK || z >= g->blocks[2] * STP_VOXEL_BLOCK;
}

/* The number of the block that holds a voxel, or 0. *place: the block's place. */
static inline uint32_t stp_voxel_block_of(const stp_voxel_grid *g, int x, int y, int z,
                                          size_t *place)
{
    *place = stp_voxel_place(g, x / STP_VOXEL_BLOCK, y / STP_VOXEL_BLOCK, z / STP_VOXEL_BLOCK);
    return stp_voxel_number(g, *place);
}

/* Occupies a voxel of a claimed block. A voxel beyond the grid is ignored. */
static inline void stp_voxel_grid_mark(stp_voxel_grid *grid, int x, int y, int z)
{
    const uint32_t bit = 1u << (x & (STP_VOXEL_BLOCK - 1));
    size_t place = 0;
    if (stp_voxel_beyond(grid, x, y, z))
        return;
    stp_voxel_bits *b = &grid->occupied[stp_voxel_block_of(grid, x, y, z, &place) - 1];
    uint32_t *row = &b->row[z & (STP_VOXEL_BLOCK - 1)][y & (STP_VOXEL_BLOCK - 1)];
    if (!(__atomic_load_n(row, __ATOMIC_RELAXED) & bit))
        __atomic_fetch_or(row, bit, __ATOMIC_RELAXED);
}

#endif
