/* Grids of heights in several files that are parts of one, such as the tiles of a survey: columns
 * and rows go on from file to file. Files may overlap: the first one that has a sample at a place
 * gives it. Threads: one. */
#ifndef STP_PREPROCESS_GRID_GRID_PARTS_H
#define STP_PREPROCESS_GRID_GRID_PARTS_H

#include "preprocess/grid/height_grid.h"

/* Sets *out to the least raster that holds all the others. Returns false, and leaves *out as it is,
 * if cells differ, or if columns and rows do not go on from one to the other, or if the result has
 * 2^32 places or more. */
bool stp_grid_parts_join(stp_scan_raster *out, const stp_scan_raster *parts, size_t count);

/* The file at hand. Zero: none. */
typedef struct stp_grid_part {
    uint64_t first, count;  /* of the file's records among all records */
    uint32_t column, row;   /* of its first sample, in the whole */
    stp_scan_raster raster; /* its own */
    uint64_t *there;        /* a bit for each of its places: a file before has a sample there */
    stp_dbox box;           /* of all samples before */
} stp_grid_part;

/* Where a file's records, which begin at `first`, lie in the whole. Has no marks. */
stp_grid_part stp_grid_part_at(const stp_scan_raster *whole, const stp_scan_raster *file,
                               uint64_t first);
/* Goes on to a file whose records begin at `first`, in place of the one before. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_grid_part_begin(stp_grid_part *part, const stp_height_grid *grid,
                               const stp_scan_raster *file, uint64_t first, stp_error *err);
/* The place in the whole of the file's record `index`. */
uint64_t stp_grid_part_place(const stp_grid_part *part, const stp_scan_raster *whole,
                             uint64_t index);
/* Whether two files have places in common. */
bool stp_grid_parts_overlap(const stp_grid_part *parts, size_t count);
/* Removes the file's samples from the grid. */
void stp_grid_part_forget(const stp_grid_part *part, stp_height_grid *grid);
void stp_grid_part_clear(stp_grid_part *part);

#endif
