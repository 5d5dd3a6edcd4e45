/* What a patch's samples imply: the errors, cone and bound that preprocessing stores and verify
 * recomputes. One code for both, on decoded samples, so that quantisation is inside the bound.
 *
 * Positions are relative to the chunk's origin, world units. Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_MEASURE_PATCH_BOUNDS_H
#define STP_FORMATS_CHUNK_MEASURE_PATCH_BOUNDS_H

#include "formats/chunk/sample.h"

/* Rim points at which a merged disc is compared with the discs under it; the centre is one more. */
#define STP_RIM_POINTS 16
#define STP_DISC_POINTS (STP_RIM_POINTS + 1)

/* A sample as a disc, with what it stands for: all zero but reach and bound (its radius) where it
 * is an original. Heights are along the disc's normal from its centre. */
typedef struct stp_disc {
    stp_dvec3 centre;
    stp_dvec3 normal; /* unit; zero where unknown: then the disc is a ball */
    double radius;
    double rgb[3];           /* 0..255 */
    double low, high;        /* heights of the originals under it */
    double reach;            /* originals lie within this distance of the centre, in the plane */
    double bound;            /* and within this distance in space */
    double cone;             /* greatest angle of an original's normal, radians */
    double error;            /* stored perpendicular error of the sample */
    double tangential_error; /* likewise */
    double colour_error;     /* what it averages of colours: stp_colour_variation */
} stp_disc;

/* What a merged disc does to the discs it replaces. */
typedef struct stp_merge_error {
    double error;
    double least_error; /* what a file must hold: where the discs are all on one side of the merged
                           one's plane, their extent; files of the first writers have no more */
    double low, high, reach, bound, cone;
} stp_merge_error;

/* A decoded sample as a disc that stands for itself alone. */
stp_disc stp_disc_from_sample(const stp_sample *sample, const stp_patch *patch);

/* Errors of `merged` over the count discs under it. Perpendicular: how far the discs reach over or
 * under its plane, along its normal, never less than what any of them has, nor than the height over
 * the nearest disc of the centre or a rim point. Dachsbacher et al. 2003 take the distance of the
 * two planes that hold the discs between them; but the merged disc is drawn in its own plane, and
 * what it stands for lies off that by the greater side alone, as it does off what it stands for.
 * The tangential error needs the discs around, too: overhang.h. */
stp_merge_error stp_merge_measure(const stp_disc *merged, const stp_disc *discs, unsigned count);

/* What a level of a patch averages of colours, 0 to 255: the root of the mean square, over the
 * level-0 samples, of how far a channel is from that of the merged sample above it; the greatest
 * of the three. What a level-0 sample averages itself is in it: variances add. merged: the level's
 * discs, finest: those of level 0. A mean, not a bound: it weighs how much detail a level hides,
 * and a bound would be that of the worst sample, which in a scan is noise. */
double stp_colour_variation(const stp_disc *merged, const stp_disc *finest,
                            const uint8_t counts[STP_LEVEL_COUNT], int level);

/* A stored bound holds what is greater by rounding. */
#define STP_STORED_SLACK 1.000001

/* The greatest error that does not exceed the stored code, world units. */
static inline double stp_error_held(uint8_t code, const stp_patch *patch)
{
    return stp_error_decode(code, patch->exponent) * STP_STORED_SLACK +
           ldexp(1e-9, patch->exponent);
}

/* Two unit vectors that span the plane of a unit normal (Duff et al. 2017). */
void stp_disc_axes(stp_dvec3 normal, stp_dvec3 *u, stp_dvec3 *v);

/* The points of a disc that are compared: its centre and, but of a ball or a point, its rim.
 * Returns how many. */
unsigned stp_disc_points(const stp_disc *disc, stp_dvec3 out[STP_DISC_POINTS]);

#endif
