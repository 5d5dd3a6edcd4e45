/* Where a grid of heights has no samples, and how far from there a place is. By that merged discs
 * are limited, so that they cover no place that level 0 leaves open (--holes grow).
 *
 * A pyramid of bits: a word has 8 x 8 samples, a word above it 8 x 8 words, and so on. It takes 1/7
 * byte a sample. Threads: one fills it; then any may ask. */
#ifndef STP_PREPROCESS_PATCH_HOLES_H
#define STP_PREPROCESS_PATCH_HOLES_H

#include "formats/chunk/measure/patch_bounds.h"
#include "formats/scan/scan.h"

/* 8^8 samples are more than a grid has on a side. */
#define STP_HOLES_LEVELS 8

typedef struct stp_holes {
    stp_scan_raster raster;
    double margin; /* what stays open around a place without a sample, world units */
    uint64_t *words[STP_HOLES_LEVELS];
    uint32_t columns[STP_HOLES_LEVELS], rows[STP_HOLES_LEVELS]; /* of words */
    unsigned level_count;
} stp_holes;

/* Makes the pyramid of a straight grid that has all samples. Errors: OUT_OF_MEMORY. Clear with
 * stp_holes_clear. */
stp_status stp_holes_create(stp_holes *out, const stp_scan_raster *raster, stp_error *err);
/* There is no sample at a column and row. After the last one call stp_holes_finish. */
void stp_holes_add(stp_holes *holes, uint32_t column, uint32_t row);
void stp_holes_finish(stp_holes *holes);
void stp_holes_clear(stp_holes *holes);

/* The distance in the plane from a place, world, to the nearest one where a sample is missing;
 * `most`, if there is none so near. Beyond the grid all are missing. */
double stp_holes_distance(const stp_holes *holes, double x, double y, double most);
/* The greatest radius of a disc about a place, world. 0: too near, if only a point is left. */
double stp_holes_radius(const stp_holes *holes, stp_dvec3 place, double most);

/* Limits a merged disc, which is stored on a lattice of this step. If it must be smaller at its
 * centre, it lies there or at one of the finer discs: where it leaves out least of them. If it
 * would be smaller than a step, it becomes a point. origin: of the discs' places, on the lattice.
 * Returns whether the disc was changed. */
bool stp_holes_limit(const stp_holes *holes, stp_dvec3 origin, const stp_disc *finer,
                     unsigned count, double step, stp_disc *disc);

#endif
