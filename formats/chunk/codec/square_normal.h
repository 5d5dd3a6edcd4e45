/* Normals of a level of a block of squares, from its heights: of the plane that fits best through
 * the samples of a window. formats/SPEC.md, "Squares", has the arithmetic. Threads: any, one map
 * each. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_NORMAL_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_NORMAL_H

#include "formats/chunk/codec/square_map.h"

typedef struct stp_square_normals {
    int level, reach;
    double length; /* of a step of the finest lattice, by the side of a cell in columns or rows */
} stp_square_normals;

/* Sums up the rows of all windows, in map->sums. All heights of the level are set. */
stp_square_normals stp_square_normals_begin(const stp_square_map *map, int level, unsigned reach);
/* The slopes of the plane through a sample's window, by column and by row, in steps a cell. */
void stp_square_slopes_at(const stp_square_normals *normals, const stp_square_grid *grid,
                          uint32_t sample, double out[2]);
/* The normal that slopes tell, as octahedral code u, v, not rounded; 0 to 4095, or no number. */
void stp_square_normal_of(const stp_square_normals *normals, const stp_raster *raster,
                          const double slopes[2], double out[2]);

#endif
