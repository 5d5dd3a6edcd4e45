/* Where a grid has no samples, and how far a place is from there. This distance limits discs, so
 * that they cover no place that level 0 leaves open (--holes grow).
 *
 * The grid is one of heights, straight or bent, whose missing samples are places in the plane; or
 * an image, whose missing samples are rays from its station. Around the grid lies a ring of missing
 * samples. Their distance is found by a pyramid: a word has a bit for each of 8 x 8 samples and the
 * box of those that are missing, a word above it the same of 8 x 8 words. It takes up to 0.6 bytes
 * a sample, near holes. Threads: one fills it; then any may ask. */
#ifndef STP_PREPROCESS_PATCH_HOLES_H
#define STP_PREPROCESS_PATCH_HOLES_H

#include "base/error.h"
#include "formats/chunk/measure/patch_bounds.h"

/* 8^8 samples are more than a grid has on a side. */
#define STP_HOLES_LEVELS 8

/* Where a sample would be, at height 0; of an image the direction of its ray, of length 1. Columns
 * and rows go from -1 to the grid's count. */
typedef stp_dvec3 stp_holes_place(const void *context, int64_t column, int64_t row);

typedef struct stp_holes_grid {
    uint32_t columns, rows;
    double cell; /* its lesser side; of an image: of a pixel at distance 1 */
    bool rays;   /* it is an image */
    bool round;  /* it goes all around: its last column is beside the first */
    stp_dvec3 station;
    stp_holes_place *place;
    const void *context; /* borrowed */
} stp_holes_grid;

typedef struct stp_holes_word {
    uint64_t bits;
    float low[3], high[3]; /* relative to the middle */
} stp_holes_word;

/* All zero: there is nothing that discs may not cover. */
typedef struct stp_holes {
    stp_holes_grid grid;
    stp_dvec3 middle;
    stp_holes_word *words[STP_HOLES_LEVELS];
    uint32_t columns[STP_HOLES_LEVELS], rows[STP_HOLES_LEVELS]; /* of words */
    unsigned level_count;
} stp_holes;

/* Makes the pyramid of a grid that has all samples. Errors: OUT_OF_MEMORY. Clear with
 * stp_holes_clear. */
stp_status stp_holes_create(stp_holes *out, const stp_holes_grid *grid, stp_error *err);
/* There is no sample at a column and row. After the last one call stp_holes_finish. */
void stp_holes_add(stp_holes *holes, uint32_t column, uint32_t row);
void stp_holes_finish(stp_holes *holes);
void stp_holes_clear(stp_holes *holes);

/* The distance from a place, world, to the nearest one where a sample is missing, in the plane, or
 * to the nearest such ray; `most`, if there is none so near. */
double stp_holes_distance(const stp_holes *holes, stp_dvec3 place, double most);
/* The greatest radius of a disc about a place, world, at most `most`. 0: too near, if only a point
 * is left. */
double stp_holes_radius(const stp_holes *holes, stp_dvec3 place, double most);

/* Limits a merged disc, which is stored on a lattice of this step. If it must be smaller at its
 * centre, it lies there or at one of the finer discs: where it leaves out least of them. If it
 * would be smaller than a step, it becomes a point. origin: of the discs' places, on the lattice.
 * Returns whether the disc was changed. */
bool stp_holes_limit(const stp_holes *holes, stp_dvec3 origin, const stp_disc *finer,
                     unsigned count, double step, stp_disc *disc);

#endif
