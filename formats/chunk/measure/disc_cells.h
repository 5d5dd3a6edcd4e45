/* Hashed cells of space: blocks of 4 x 4 x 4 cells are hashed, the cells of a block lie together.
 *
 * A bucket number is put together from one part for each axis, so a search along one axis keeps the
 * parts of the other two. Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_MEASURE_DISC_CELLS_H
#define STP_FORMATS_CHUNK_MEASURE_DISC_CELLS_H

#include <stdint.h>

typedef struct stp_cell_part {
    uint32_t block, cell;
} stp_cell_part;

/* The cell that holds a coordinate, given in cell widths. */
static inline int stp_cell_floor(float x)
{
    int i = (int)x;
    return i - (x < (float)i);
}

/* axis: 0 to 2. Along axis 2, the cells of a block have consecutive buckets. */
static inline stp_cell_part stp_cell_part_of(int axis, int at)
{
    static const uint32_t factors[3] = {0x9e3779b1u, 0x85ebca6bu, 0xc2b2ae35u};
    uint32_t h = (uint32_t)(at >> 2) * factors[axis];
    return (stp_cell_part){h ^ h >> 15, (uint32_t)(at & 3) << 2 * (2 - axis)};
}

/* mask: the number of blocks, a power of two, less one. */
static inline uint32_t stp_cell_bucket(uint32_t mask, stp_cell_part x, stp_cell_part y,
                                       stp_cell_part z)
{
    return ((x.block ^ y.block ^ z.block) & mask) << 6 | x.cell | y.cell | z.cell;
}

#endif
