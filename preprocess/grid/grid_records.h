/* Grids of heights that ranks share. Each rank reads a part of the records. When all are read, it
 * is known which tiles have samples, so which rank makes a leaf of a tile: the rank gets the tile's
 * samples and those around it, as far as normals reach. Its grid (height_grid.h) is sparse: places
 * that it does not need take no memory.
 *
 * Memory of a rank: 8 bytes a sample of its part, 16 more of a bent raster or if files overlap, 6
 * more with colours, in the spill, until ranks have given them to each other; then those of its
 * tiles, in whole pages of 4 KB. If files overlap, a bit for each place of the whole. Threads: one.
 */
#ifndef STP_PREPROCESS_GRID_GRID_RECORDS_H
#define STP_PREPROCESS_GRID_GRID_RECORDS_H

#include "preprocess/grid/grid_parts.h"
#include "preprocess/ranks/ranks.h"

/* No rank makes a leaf of a tile: it has no samples. */
#define STP_TILE_OF_NONE UINT32_MAX

/* Records [begin, end), which this rank reads. Zero: none. */
typedef struct stp_grid_records {
    stp_scan_raster whole;
    stp_grid_part *parts; /* of all files with records, in order; without marks */
    size_t part_count;
    bool overlap; /* some files have places in common */
    uint64_t begin, end;
    double *z;          /* by record; NaN: no sample */
    double (*xy)[2];    /* likewise; NULL: a sample is where its place is */
    uint16_t (*rgb)[3]; /* likewise; NULL: no colours */
    uint64_t count;     /* of samples */
    stp_spill *spill;   /* borrowed */
} stp_grid_records;

/* Makes room for records. bent, coloured: of the grid. Takes the parts, also after a failure.
 * Errors: OUT_OF_MEMORY, IO. Free with stp_grid_records_clear. */
stp_status stp_grid_records_create(stp_grid_records *out, const stp_scan_raster *whole,
                                   stp_grid_part *parts, size_t part_count, stp_rank_part records,
                                   bool bent, bool coloured, stp_spill *spill, stp_error *err);
/* Each record must be set or left out. */
void stp_grid_records_set(stp_grid_records *records, uint64_t record, const stp_point *point);
void stp_grid_records_leave_out(stp_grid_records *records, uint64_t record);
/* If several samples have one place, only that of the first record stays, whichever rank read it.
 * All ranks call it. *twice: the others of this rank, by record in ascending order, 32 bits each.
 * *box becomes that of this rank's samples, if files overlap. Errors: OUT_OF_MEMORY, IO, CANCELLED.
 */
stp_status stp_grid_records_sift(stp_grid_records *records, stp_ranks *ranks, stp_bytes *twice,
                                 stp_dbox *box, stp_error *err);
/* Adds up how many samples of all ranks each tile has. Errors: OUT_OF_MEMORY, IO, CANCELLED. */
stp_status stp_grid_records_count(const stp_grid_records *records, stp_height_grid *grid,
                                  stp_ranks *ranks, stp_error *err);
/* Gives each sample to the ranks that need it, and puts those that come into the grid, which is
 * sparse. owners: by tile, the rank that makes its leaf, or STP_TILE_OF_NONE. most: records that a
 * rank has at most. All ranks call it. Errors: OUT_OF_MEMORY, IO, INTERNAL, CANCELLED. */
stp_status stp_grid_records_give(const stp_grid_records *records, stp_height_grid *grid,
                                 const uint32_t *owners, uint64_t most, stp_ranks *ranks,
                                 stp_error *err);
void stp_grid_records_clear(stp_grid_records *records);

#endif
