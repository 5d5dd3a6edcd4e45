/* The errors, cone and bound that a patch's samples imply: preprocessing stores them, verify
 * recomputes them. Both run this code on decoded samples, so quantisation is inside the bound.
 *
 * The perpendicular error e of a merged disc D over the level-0 discs d under it. N is the unit
 * normal of D; s is the height of d's centre over the plane of D, along N; r is the radius of d,
 * beta the angle between the normals of d and D:
 *
 *         . . . . . . . . . . .   s + r sin(beta)
 *                  /
 *                 d               s: its centre
 *                /
 *         . . . . . . . . . . .   s - r sin(beta)
 *    =============D============   0
 *
 *    side   = max over d of (|s| + r sin(beta))
 *    extent = max over d of (s + r sin(beta)) - min over d of (s - r sin(beta))
 *    rim    = max over p of the height of p over the plane of the d nearest to p
 *    p: the centre of D and its 16 rim points
 *
 *    measured and stored: e  = max(side, rim)                 stp_merge_error.error
 *    a file must hold:    e >= max(min(side, extent), rim)    stp_merge_error.least_error
 *
 * No p lies farther from the plane of any d than off, so e lies between side and max(side, off):
 *
 *    off    = max over d of (height of D's centre over the plane of d + r(D) sin(beta))
 *
 * If d itself stands for originals, side and extent run over these; the height of p over d grows by
 * the error of d; and e is no less than the error of any d.
 *
 * Example: two discs parallel to D, at s = 0.01 and s = 0.03; the lower one is nearest to every
 * point of D. side = 0.03, extent = 0.02, rim = 0.01: a writer stores 0.03, and verify accepts
 * 0.02.
 *
 * The tangential error t needs the discs around, too: overhang.h.
 *
 * Positions are relative to the chunk's origin, world units. Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_MEASURE_PATCH_BOUNDS_H
#define STP_FORMATS_CHUNK_MEASURE_PATCH_BOUNDS_H

#include "formats/chunk/measure/rim.h"
#include "formats/chunk/sample/sample.h"

/* Rim points at which a merged disc is compared with the discs under it. The centre is one point
 * more. */
#define STP_DISC_POINTS (STP_RIM_POINTS + 1)

/* A sample as a disc, with the originals that it stands for. For an original, reach and bound are
 * its radius, and every field from low on is else zero. Heights are along the disc's normal, from
 * its centre. */
typedef struct stp_disc {
    stp_dvec3 centre;
    stp_dvec3 normal; /* unit; zero where unknown: then the disc is a ball */
    double radius;
    double rgb[3];           /* 0..255 */
    double low, high;        /* least and greatest height of the originals under it */
    double reach;            /* originals lie within this distance of the centre, in the plane */
    double bound;            /* and within this distance in space */
    double cone;             /* greatest angle of an original's normal, radians */
    double error;            /* perpendicular error that the sample stores */
    double tangential_error; /* tangential error that the sample stores */
    double colour_error;     /* the colours that it averages away: stp_colour_variation */
} stp_disc;

/* How a merged disc differs from the discs that it replaces. */
typedef struct stp_merge_error {
    double error;
    double least_error; /* what a file must hold: less than error if all discs lie on one side of
                           the merged disc's plane; files of the first writers have no more */
    double low, high, reach, bound, cone;
} stp_merge_error;

/* A decoded sample as a disc that stands for itself alone. */
stp_disc stp_disc_from_sample(const stp_sample *sample, const stp_patch *patch);

/* Errors of `merged` over the `count` discs under it; the formulas are at the top. Dachsbacher et
 * al. 2003 take the distance of the two planes that hold the discs between them (extent). We take
 * the greater side: the merged disc is drawn in its own plane, so what it stands for lies off that
 * plane by one side only. */
stp_merge_error stp_merge_measure(const stp_disc *merged, const stp_disc *discs, unsigned count);
/* The error lies between these. Nothing is looked for: cheaper than the error. */
typedef struct stp_error_bounds {
    double low, high;
} stp_error_bounds;
stp_error_bounds stp_merge_bound_error(const stp_disc *merged, const stp_disc *discs,
                                       unsigned count);
/* rim, or `least` if that is more. */
double stp_merge_measure_rim(const stp_disc *merged, const stp_disc *discs, unsigned count,
                             double least);

/* How much colour a level of a patch averages away, 0 to 255. For each channel: the root of the
 * mean square, over the level-0 samples, of the difference from the merged sample above. Returns
 * the greatest of the three channels. What a level-0 sample averages away itself is added:
 * variances add. merged: the level's discs; finest: the discs of level 0. This is a mean, not a
 * bound. It weighs how much detail a level hides; a bound would tell of the worst sample only,
 * which in a scan is noise. */
double stp_colour_variation(const stp_disc *merged, const stp_disc *finest,
                            const uint8_t counts[STP_LEVEL_COUNT], int level);

/* Rounding may make a recomputed bound greater than the stored one by this factor. */
#define STP_STORED_SLACK 1.000001

/* The greatest error that the stored code still holds, world units. */
static inline double stp_error_held(uint8_t code, const stp_patch *patch)
{
    return stp_error_decode(code, patch->exponent) * STP_STORED_SLACK +
           ldexp(1e-9, patch->exponent);
}

/* Two unit vectors that span the plane of a unit normal (Duff et al. 2017). */
void stp_disc_axes(stp_dvec3 normal, stp_dvec3 *u, stp_dvec3 *v);

/* The points of a disc that are compared: its centre and its rim points; for a ball or a point the
 * centre alone. Returns how many. */
unsigned stp_disc_points(const stp_disc *disc, stp_dvec3 out[STP_DISC_POINTS]);

#endif
