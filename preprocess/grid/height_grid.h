/* A grid of heights, and the leaves that it becomes: tiles of 256 x 256 samples, whose patches are
 * squares of 8 x 8.
 *
 * A grid says who a sample's neighbours are. So nothing is sorted or searched: spacings and normals
 * follow from the heights around a sample. A sample's disc is as wide as the surface of its cell,
 * but not wider than twice the cell: cliffs stay open. Its normal is that of the plane that fits
 * best through (2 reach + 1)^2 samples; reach is the least at which the grid's noise turns normals
 * by 2 degrees or less.
 *
 * Memory: 8 bytes a sample, 6 more with colours, 16 more of a bent raster, in the spill. Threads:
 * one filler; leaves may be built on any. */
#ifndef STP_PREPROCESS_GRID_HEIGHT_GRID_H
#define STP_PREPROCESS_GRID_HEIGHT_GRID_H

#include "base/spill.h"
#include "formats/chunk/codec/square/square.h"
#include "formats/scan/scan.h"
#include "preprocess/grid/raster_frame.h"
#include "preprocess/ranks/ranks.h"
#include "preprocess/tree/chunk_build.h"

/* Samples on a side of a leaf, so that one has at most 65,536. */
#define STP_TILE_SIDE 256u
/* Greatest reach of a normal's window. */
#define STP_GRID_REACH STP_SQUARE_REACH_MOST

typedef struct stp_height_grid {
    stp_scan_raster raster;
    const stp_dvec3 *nodes; /* of a bent raster (scan.h), borrowed; NULL: it is straight */
    double (*xy)[2];        /* of a bent raster: where its samples are, row by row */
    double *z;              /* row by row, the top row first; NaN: no sample */
    uint16_t (*rgb)[3];     /* likewise; NULL: no colours */
    uint32_t *tile_samples; /* by tile, row by row */
    bool *own;              /* by tile: whether this rank has it, with the heights around it; NULL:
                               all are here */
    uint32_t tile_columns, tile_rows;
    uint32_t count;      /* of samples */
    stp_dbox box;        /* of samples, world */
    unsigned reach;      /* of normals; set by stp_height_grid_finish */
    double noise;        /* standard deviation of heights; likewise */
    double normal_error; /* standard error of the normals because of noise, radians */
    stp_holes *holes;    /* where merged discs may not reach; NULL: there are none, or they may */
    double move_most;    /* a bent raster's sample may be moved so far to where its frame has it */
    stp_spill *spill;    /* borrowed */
} stp_height_grid;

/* Makes an empty grid. nodes: of a bent raster, else NULL. sparse: its arrays take no memory yet,
 * since ranks share them (grid_records.h). Errors: OUT_OF_MEMORY, IO. Free with
 * stp_height_grid_clear. */
stp_status stp_height_grid_create(stp_height_grid *out, const stp_scan_raster *raster,
                                  const stp_dvec3 *nodes, bool coloured, bool sparse,
                                  stp_spill *spill, stp_error *err);
/* Sets sample `place`, counted row by row, which must not be set. In the end each place must be set
 * or left out. */
void stp_height_grid_set(stp_height_grid *grid, uint64_t place, const stp_point *point);
/* The same of samples side by side, of a grid that is straight, up to one that is none or nowhere:
 * returns how many. */
size_t stp_height_grid_take(stp_height_grid *grid, uint64_t place, const stp_point *points,
                            size_t count);
/* There is no sample at `place`. */
void stp_height_grid_leave_out(stp_height_grid *grid, uint64_t place);
/* Removes the sample at `place`. */
void stp_height_grid_unset(stp_height_grid *grid, uint64_t place);
/* Measures the noise and chooses the reach of normals. step: of the heights; 0: they have none. If
 * tiles are shared, all ranks call it. Errors: OUT_OF_MEMORY, IO, CANCELLED. */
stp_status stp_height_grid_finish(stp_height_grid *grid, double step, stp_ranks *ranks,
                                  stp_error *err);
/* Lets no disc cover a place without a sample that discs of level 0 could leave open (--holes
 * grow). The grid is finished, and stays where it is. If tiles are shared, all ranks call it.
 * Errors: OUT_OF_MEMORY, IO. */
stp_status stp_height_grid_keep_open(stp_height_grid *grid, stp_ranks *ranks, stp_error *err);
void stp_height_grid_clear(stp_height_grid *grid);

static inline uint32_t stp_height_grid_tile_count(const stp_height_grid *grid)
{
    return grid->tile_columns * grid->tile_rows;
}

/* The tile that a place, counted row by row, is in. */
static inline uint32_t stp_height_grid_tile_at(const stp_height_grid *grid, uint64_t place)
{
    const uint32_t row = (uint32_t)(place / grid->raster.columns);
    const uint32_t column = (uint32_t)(place % grid->raster.columns);
    return row / STP_TILE_SIDE * grid->tile_columns + column / STP_TILE_SIDE;
}

/* The middle of a tile that has samples, at the height of the grid's middle. */
stp_dvec3 stp_height_grid_tile_middle(const stp_height_grid *grid, uint32_t index);
/* Builds the leaf of a tile that has samples, without tangential errors. Errors: OUT_OF_MEMORY,
 * LIMIT (a height is too far from the others). */
stp_status stp_height_grid_leaf(const stp_height_grid *grid, uint32_t index,
                                const stp_point_item_params *params, stp_built_chunk *out,
                                stp_error *err);

#endif
