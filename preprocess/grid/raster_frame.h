/* Where the samples around a sample of a raster lie, of a straight raster or of a bent one
 * (scan.h). Threads: any (pure functions). */
#ifndef STP_PREPROCESS_GRID_RASTER_FRAME_H
#define STP_PREPROCESS_GRID_RASTER_FRAME_H

#include "formats/scan/scan.h"

/* Sample (column, row) of the raster is at at + (column - first[0]) by_column + (row - first[1])
 * by_row. A straight raster has one frame; a bent one has a frame for each STP_RASTER_NODE columns
 * and rows, all of whose samples it meets to a small part of their spacing. */
typedef struct stp_raster_frame {
    uint32_t first[2];
    double at[2], by_column[2], by_row[2]; /* x and y */
    double wide, deep;                     /* lengths of a cell's sides */
    double area; /* of a cell; negative where columns turn right to rows, as if rows go down in y */
} stp_raster_frame;

/* The frame around a sample. nodes: of a bent raster, else NULL. */
stp_raster_frame stp_raster_frame_at(const stp_scan_raster *raster, const stp_dvec3 *nodes,
                                     uint32_t column, uint32_t row);
/* The place of a column and row, which need not be whole, at height 0. */
stp_dvec3 stp_raster_frame_place(const stp_raster_frame *frame, double column, double row);
/* The lesser side of a cell in the raster's middle. */
double stp_raster_cell(const stp_scan_raster *raster, const stp_dvec3 *nodes);

#endif
