/* Squares of grids of heights: which samples of a grid a block's patches have.
 *
 * If a block is of squares, its patches are followed by the rasters and, for each patch, its
 * square. They tell column and row of each sample, so that positions need no bytes but for heights.
 * The grid of a survey is level: one raster, whose columns and rows go along x and y. Others are
 * tilted, several in a block: elevation maps, and pieces of a grid that another coordinate system
 * bends. formats/SPEC.md, "Squares", has the layout. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/table/table.h"

#include <math.h>
#include <string.h>

#define STP_SQUARE_SIDE 8u
#define STP_SQUARE_SAMPLES (STP_SQUARE_SIDE * STP_SQUARE_SIDE)
/* Greatest reach of a normal's window. */
#define STP_SQUARE_REACH_MOST 4u
/* In place of a reach: normals follow from those of the parents, not from heights. */
#define STP_SQUARE_REACH_PARENTS 5u
/* The same, whatever is left of the parents' normals. */
#define STP_SQUARE_REACH_LOOSE 6u
/* Likewise, and normals are whole strides off. Of levels 1 and 0. */
#define STP_SQUARE_REACH_STRIDES 7u
/* A stride is 2^stp_square_stride places of the grid of normals: 4 to 6 degrees at level 0, half of
 * that at level 1; on a grid of less than 8 bits, one place. shift: of the grid. */
static inline unsigned stp_square_stride(int level, unsigned shift)
{
    return shift > 4 ? 0 : 7u - shift - (unsigned)level;
}
/* Columns and rows of squares are less. */
#define STP_SQUARE_PLACES_LIMIT (UINT32_C(1) << 28)

/* Column and row of place i in Morton order: of a sample within a square, or of a square among
 * others. */
static inline uint32_t stp_square_column(uint32_t i)
{
    i &= 0x55555555u;
    i = (i | i >> 1) & 0x33333333u;
    i = (i | i >> 2) & 0x0f0f0f0fu;
    i = (i | i >> 4) & 0x00ff00ffu;
    return (i | i >> 8) & 0x0000ffffu;
}
static inline uint32_t stp_square_row(uint32_t i)
{
    return stp_square_column(i >> 1);
}

/* The place in Morton order of a column and row of a square. */
static inline uint32_t stp_square_morton(uint32_t column, uint32_t row)
{
    const uint32_t c = (column & 1u) | (column & 2u) << 1 | (column & 4u) << 2;
    const uint32_t r = (row & 1u) | (row & 2u) << 1 | (row & 4u) << 2;
    return c | r << 1;
}

/* Whether columns and rows spread with the height, as those of a camera's image. Several patches
 * may then have one square, cut where the depth jumps. */
static inline bool stp_raster_spreads(const stp_raster *raster)
{
    const double(*a)[6] = raster->across;
    return a[0][4] != 0.0 || a[0][5] != 0.0 || a[1][4] != 0.0 || a[1][5] != 0.0;
}

/* Whether heights are the world's, as those of a survey or a microscope; else they are those of an
 * elevation map or a camera. */
static inline bool stp_raster_is_upright(const stp_raster *raster)
{
    return raster->axis == 2 && raster->across[0][3] == 0.0 && raster->across[1][3] == 0.0 &&
           !stp_raster_spreads(raster);
}

/* Whether heights are those of an elevation map. */
static inline bool stp_raster_is_map(const stp_raster *raster)
{
    return !stp_raster_is_upright(raster) && !stp_raster_spreads(raster);
}

/* Rounds a number to a float whose lowest byte is 0: to 16 significant bits, or fewer if it is no
 * normal number. If all slopes of a tilted raster (across[k][1 ... 3]) are such numbers, and its
 * corner (across[k][0]) is of floats, it takes 29 bytes instead of 49. */
static inline double stp_raster_short(double number)
{
    const float as_float = (float)number;
    uint32_t bits;
    float out;
    if (!isfinite(as_float))
        return (double)as_float;
    memcpy(&bits, &as_float, sizeof bits);
    bits = (bits + 0x80u) & ~0xffu;
    memcpy(&out, &bits, sizeof out);
    return (double)out;
}

/* Finds the squares of a block with all levels whose rasters are set: all of one level raster, or
 * all of tilted ones. False if some patch is not a square of a grid, or its square cannot be coded.
 * out: one for each patch. */
bool stp_squares_find(const stp_chunk *block, stp_square *out);

/* Whether squares that were found are of tilted rasters. */
static inline bool stp_squares_are_tilted(const stp_chunk *block, const stp_square *squares)
{
    return !block->rasters[squares[0].raster].level;
}

/* Appends the rasters and makes the table of the squares; free table->values. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_squares_encode(const stp_chunk *block, const stp_square *squares, stp_bytes *rasters,
                              stp_table *table, stp_error *err);
/* Reads rasters into block->rasters, which are allocated. first: by raster, the square that the
 * first one counts from; free with free(). Errors: CORRUPT, OUT_OF_MEMORY. */
stp_status stp_rasters_decode(stp_cursor *c, bool tilted, stp_chunk *block, stp_square **first,
                              stp_error *err);
/* An empty table of squares, a row for each; free table->values. Errors: OUT_OF_MEMORY. */
stp_status stp_squares_table(uint32_t rows, bool tilted, stp_table *table, stp_error *err);
/* Reads the table into squares[patch_count]. first: is used up. Errors: CORRUPT. */
stp_status stp_squares_decode(const stp_table *table, const stp_chunk *block, stp_square *first,
                              stp_square *squares, stp_error *err);
/* Errors: CORRUPT (a square has not as many samples as its patch). */
stp_status stp_squares_check(const stp_chunk *block, stp_error *err);

#endif
