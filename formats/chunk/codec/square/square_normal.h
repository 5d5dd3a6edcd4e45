/* Normals of a level of a block of squares, from its heights: of the plane that fits best through
 * the samples of a window. formats/SPEC.md, "Squares", has the arithmetic. Threads: any, one map
 * each. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_NORMAL_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_NORMAL_H

#include "formats/chunk/codec/square/square_map.h"

typedef struct stp_square_normals {
    int level, reach;
    double length; /* of a step of the finest lattice, by the side of a cell in columns or rows */
} stp_square_normals;

/* What a normal depends on besides slopes. */
typedef struct stp_square_place {
    double tilt[2]; /* stp_square_tilt */
    double height;  /* from the chunk's origin */
} stp_square_place;

stp_square_place stp_square_place_of(const stp_square_normals *normals, const stp_square_grid *grid,
                                     uint32_t sample);

/* Sums up the rows of all windows, in map->sums. All heights of the level are set. */
stp_square_normals stp_square_normals_begin(const stp_square_map *map, int level, unsigned reach);
/* The code of a sample's normal, as stp_square_normal_of gives it, if it is known at once: of a
 * level grid, whose window lacks no sample. */
bool stp_square_code_at(const stp_square_normals *normals, const stp_square_grid *grid,
                        uint32_t sample, double out[2]);
/* The slopes of the plane through a sample's window, by column and by row, in steps a cell; not of
 * one whose code is known at once. */
void stp_square_slopes_at(const stp_square_normals *normals, const stp_square_grid *grid,
                          uint32_t sample, double out[2]);
/* The octahedral code u, v of a direction of any length, not rounded; 0 to 4095, or no number. */
void stp_square_direction(const double n[3], double out[2]);
/* That of the normal that slopes tell at a place. */
void stp_square_normal_of(const stp_square_normals *normals, const stp_raster *raster,
                          const stp_square_place *at, const double slopes[2], double out[2]);

/* Moves a place that lies beyond the grid of normals onto it. Each half of a side of the grid is
 * folded upon the other: what lies beyond it is on the grid, too. top: the last place. */
void stp_square_fold(int32_t place[2], int32_t top);
/* Moves a place of the grid, own, to one that folds to it and is off `expected` by multiples of
 * 2^stride: the nearest. If there is none, own stays, and the answer is false. sides: own is the
 * lesser of two on a side (normal_grid.h), and stands for both. */
bool stp_square_unfold(int32_t own[2], const int32_t expected[2], int32_t top, bool sides,
                       unsigned stride);

#endif
