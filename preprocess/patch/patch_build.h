/* One patch: quantised samples, merged levels and their errors. */
#ifndef STP_PREPROCESS_PATCH_PATCH_BUILD_H
#define STP_PREPROCESS_PATCH_PATCH_BUILD_H

#include "preprocess/patch/item.h"

#include <math.h>
#include <stdbool.h>

/* Of a positive, finite value. */
static inline int stp_floor_log2(double value)
{
    int exponent = 0;
    (void)frexp(value, &exponent);
    return exponent - 1;
}

/* To the nearest whole number, halves to the even one; |x| < 2^51. */
static inline double stp_nearest_whole(double x)
{
    const double shift = 0x1.8p52;
    return x + shift - shift;
}

/* A merged disc's radius is at least so many of its own spacings. */
#define STP_MERGED_LAMBDA 1.4
/* A patch is no more steps wide than 16 bits tell, with room for rounding; its origin is no more
 * steps from the chunk's than 32 bits tell. */
#define STP_POSITION_STEPS 65533.0
#define STP_ORIGIN_STEPS 2e9
/* A sample's position is kept to the local spacing over this, or better. */
#define STP_SPACING_PARTS 32.0

typedef struct stp_patch_samples {
    stp_sample level[STP_LEVEL_COUNT][STP_PATCH_SAMPLES];
} stp_patch_samples;

/* Exponent of the lattice on which a position is within spacing / STP_SPACING_PARTS, and precision
 * if that is positive; but not so fine that the disc's radius has no code there, which is some ten
 * thousand times finer than the surface is sampled. */
int stp_lattice_exponent(double spacing, double radius, double precision, stp_dvec3 position);

/* Exponent of the lattice of a patch's vertex, which is a sample of the parent, too: by the sum of
 * the items' areas, but coarse enough for a ball of radius `reach` to have a code there, and no
 * finer than `finest`. Grows with each of the three. */
int stp_vertex_exponent(double area, double reach, int finest);

/* What all patches of a chunk are built on. */
typedef struct stp_patch_ground {
    stp_dvec3
        origin;  /* the chunk's: a multiple of every lattice of its items and of its vertices */
    bool copied; /* the items are vertices of patches below: they are stored as they are */
    int vertex_least; /* vertices have no finer lattice */
} stp_patch_ground;

/* Builds the patch of items[order[0..count)), count 1..64, in stp_partition's order. On success
 * *vertex is the patch vertex as an item of the parent chunk. Returns false if the items are too
 * far apart for their lattice: then the caller parts them. A single item fits where the chunk is
 * not too wide for it. */
bool stp_patch_build(const stp_item *items, const uint32_t *order, unsigned count,
                     const stp_patch_ground *ground, stp_patch *patch, stp_patch_samples *samples,
                     stp_item *vertex);

#endif
