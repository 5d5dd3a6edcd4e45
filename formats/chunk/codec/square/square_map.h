/* The samples of a block of squares as grids: for each raster one for each level.
 *
 * The place of a level-0 sample is its column and row; that of a merged sample is the mean of its
 * children's places. At level l, a cell of a grid has a side of 2^l samples. From the places of
 * neighbours and their values follow slopes, and from these what to expect of children and normals.
 * formats/SPEC.md, "Squares", has the arithmetic: doubles, each step rounded by itself, the same on
 * every machine. Threads: any, one map each. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_MAP_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_MAP_H

#include "formats/chunk/codec/inline.h"
#include "formats/chunk/codec/square/square.h"

#include <math.h>

/* Numbers of a cell in sums. */
#define STP_SQUARE_SUMS 8
/* Values of a parent that need room: three colours, or three components of its normal. */
#define STP_SQUARE_PARENT_VALUES 3

/* Indices of samples are those of the block's levels, the same in all grids. */
typedef struct stp_square_level {
    double *column, *row; /* place of a sample */
    double *across[2];    /* by column and row alone, where it should be along the axes across its
                             height, in steps of its patch's lattice from the chunk's origin */
    double *height;       /* in steps of the finest lattice from the chunk's origin */
    int32_t *cells;       /* which sample is in a cell; -1: none */
    int32_t *before;      /* the sample before in the cell of a sample; -1: none */
    int cell_columns, cell_rows;
} stp_square_level;

/* The samples of a raster. */
typedef struct stp_square_grid {
    const stp_raster *raster;
    stp_square_level level[STP_LEVEL_COUNT];
    double *sums; /* room for STP_SQUARE_SUMS numbers of each cell of level 0; NULL: no planes */
    uint32_t column, row; /* first column and row of samples */
} stp_square_grid;

typedef struct stp_square_map {
    void *memory;
    const stp_square *squares; /* by patch; borrowed */
    stp_square_grid *grids;
    uint32_t first_raster, grid_count;
    double *sums;               /* of all grids, one behind the other; also values of the parents */
    int exponent;               /* of the finest lattice */
    bool stops;                 /* slopes of heights stop at jumps: those of all rasters do */
    bool full[STP_LEVEL_COUNT]; /* no cell of the level's grids is empty */
} stp_square_map;

/* Makes the map of a block whose squares are known; they and the rasters are borrowed. planes:
 * normals may follow from planes (square_normal.h), which takes more memory. Heights are not set.
 * Errors: OUT_OF_MEMORY, CORRUPT (two patches have one square, squares are too far apart, lattices
 * too unlike). Free with stp_square_map_clear. */
stp_status stp_square_map_create(const stp_chunk *block, const stp_square *squares, bool planes,
                                 stp_square_map *out, stp_error *err);
void stp_square_map_clear(stp_square_map *map);

/* The factor from steps of a patch's lattice to steps of the finest lattice, 1 to 256. */
double stp_square_map_steps(const stp_square_map *map, const stp_patch *patch);

/* Whether a cell of the grid beside that of a sample is empty. */
bool stp_square_is_beside_hole(const stp_square_map *map, const stp_square_grid *grid, int level,
                               uint32_t sample);

/* The grid of a patch. */
STP_INLINE const stp_square_grid *stp_square_grid_of(const stp_square_map *map, uint32_t patch)
{
    return &map->grids[map->squares[patch].raster - map->first_raster];
}

/* How the place of a sample along axis k across the height changes with the height. */
STP_INLINE double stp_square_tilt(const stp_square_grid *grid, int level, uint32_t sample, int k)
{
    const double *a = grid->raster->across[k];
    return a[3] + ((grid->column + grid->level[level].column[sample]) * a[4] +
                   (grid->row + grid->level[level].row[sample]) * a[5]);
}

/* The whole number nearest to x, halves up; 0 for a number beyond 2^30, or none. */
STP_INLINE int32_t stp_square_whole(double x)
{
    return fabs(x) <= 1073741824.0 ? (int32_t)floor(x + 0.5) : 0;
}

/* The position along axis k across the height that a sample of a patch should have, by its position
 * along the height. */
STP_INLINE int32_t stp_square_across(const stp_square_grid *grid, int level, uint32_t sample, int k,
                                     const stp_patch *patch, uint16_t position)
{
    const unsigned axis = grid->raster->axis;
    const double height = (double)patch->origin[axis] + position;
    const double tilt = grid->raster->level ? 0.0 : stp_square_tilt(grid, level, sample, k);
    const double at = grid->level[level].across[k][sample] + tilt * height;
    return stp_square_whole(at - patch->origin[(axis + 1 + (unsigned)k) % 3]);
}

/* The sample in a cell; -1: none, or outside. */
STP_INLINE int32_t stp_square_at(const stp_square_level *level, int column, int row)
{
    return column < 0 || row < 0 || column >= level->cell_columns || row >= level->cell_rows
               ? -1
               : level->cells[(size_t)row * (size_t)level->cell_columns + (size_t)column];
}

/* The cell of a place along an axis. */
STP_INLINE int stp_square_cell(double place, int level)
{
    return (int)place >> level;
}

#endif
