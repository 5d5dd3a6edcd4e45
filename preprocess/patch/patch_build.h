/* Builds one patch: quantised samples, merged levels and their errors. */
#ifndef STP_PREPROCESS_PATCH_PATCH_BUILD_H
#define STP_PREPROCESS_PATCH_PATCH_BUILD_H

#include "preprocess/patch/holes.h"
#include "preprocess/patch/item.h"
#include "preprocess/patch/lattice.h"

#include <math.h>
#include <stdbool.h>

/* Rounds to the nearest whole number, halves to even; |x| < 2^51. */
static inline double stp_nearest_whole(double x)
{
    const double shift = 0x1.8p52;
    return x + shift - shift;
}

/* Limits in lattice steps: a patch is no wider than 16 bits can say, with room for rounding; its
 * origin is no farther from the chunk's than 32 bits can say. */
#define STP_POSITION_STEPS 65533.0
#define STP_ORIGIN_STEPS 2e9
/* Bits of the grid of merged normals of squares. */
#define STP_MERGED_SQUARE_BITS 9u
/* Those that squares of noisy normals of so many bits need. */
static inline unsigned stp_merged_bits(unsigned normal_bits)
{
    return normal_bits < STP_MERGED_SQUARE_BITS ? normal_bits + 1 : STP_MERGED_SQUARE_BITS;
}

/* Errors of depth cameras' images are noise: a quarter of an octave, rounded up, tells them as
 * well.
 */
static inline uint8_t stp_rough_error(uint8_t code)
{
    return code < UINT8_MAX ? (uint8_t)((code + 1u) & ~1u) : code;
}

typedef struct stp_patch_samples {
    stp_sample level[STP_LEVEL_COUNT][STP_PATCH_SAMPLES];
} stp_patch_samples;

/* The grid of a patch that is a square. Merged samples lie where a codec expects them. */
typedef struct stp_patch_grid {
    stp_dvec3 along;      /* of the heights' axis; the component of greatest magnitude is 1 */
    double spacing;       /* of an elevation map: between level-0 samples, world units; else 0 */
    unsigned merged_bits; /* of the grid of merged normals, at most STP_MERGED_SQUARE_BITS */
    double noise;         /* standard deviation of level-0 heights, world units; 0: not known */
    bool level;           /* columns and rows are those of a level raster */
    bool spreads;         /* the samples lie on rays from the station, world */
    stp_dvec3 station;
    /* Normals of levels 1 and 2, from which finer ones are predicted; counts 0: the normals are
     * means. */
    const stp_dvec3 *merged[2];
    unsigned merged_counts[2];
} stp_patch_grid;

/* How much larger a map's surface is than its plane counts in steps of sqrt(2), up to this many:
 * the codec predicts radii by the same steps (square_level.c). */
#define STP_STRETCH_STEPS 4

/* How much larger the surface is where a normal has this cosine with the map's axis. */
static inline double stp_stretch(double cosine)
{
    int steps = 0;
    for (double ratio = M_SQRT2; steps < STP_STRETCH_STEPS && ratio * cosine * cosine <= 1.0;
         ratio *= 2.0)
        steps++;
    return exp2(0.5 * steps);
}

/* What all patches of a chunk share. */
typedef struct stp_patch_ground {
    stp_dvec3 origin;     /* the chunk's: a multiple of every lattice of its items and vertices */
    bool copied;          /* the items are patch vertices from below: stored unchanged */
    int vertex_least;     /* exponent of the finest lattice of vertices */
    unsigned normal_bits; /* of the grid of level-0 normals; level l has l + 1 more, up to 12;
                             squares l more, up to 9 */
    bool even;            /* squares: merged by plain means, whatever their radii; then 9 bits */
    bool regular; /* all discs are of a grid of heights: merged ones are no wider than cells */
    const stp_patch_grid *grid; /* NULL: none */
    const stp_holes *holes;     /* by sheet, less STP_SHEET_APART: what merged discs may not cover;
                                   NULL: nothing */
} stp_patch_ground;

/* Builds the patch of items[order[0..count)), count 1..64, in stp_partition's order. On success
 * *vertex is the patch vertex as an item of the parent chunk. Returns false if the items are too
 * far apart for their lattice; the caller then splits them. A single item always fits, unless the
 * chunk is too wide for it. */
bool stp_patch_build(const stp_item *items, const uint32_t *order, unsigned count,
                     const stp_patch_ground *ground, stp_patch *patch, stp_patch_samples *samples,
                     stp_item *vertex);

#endif
