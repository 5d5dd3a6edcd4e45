/* How wide merged discs are. Threads: any. */
#ifndef STP_PREPROCESS_PATCH_MERGED_RADIUS_H
#define STP_PREPROCESS_PATCH_MERGED_RADIUS_H

#include "preprocess/patch/lattice.h"

#include <math.h>
#include <stdbool.h>

/* A merged disc's radius is at least this many of its own spacings. */
#define STP_MERGED_LAMBDA 1.4
/* In grids of heights, whose cells have no gaps: at least so many, and at least this many times as
 * far as the finer centres. */
#define STP_REGULAR_LAMBDA 1.1
#define STP_CORNER_SHARE 2.1
/* Radii of maps, as parts of that of a full cell, and of depth cameras' images: so many an octave.
 */
#define STP_RADIUS_PARTS 2.0

/* How wide a merged disc need be, given its area and how far off the finer centres are. In a
 * regular grid's cell the centres lie half as far off as the corners, and discs must reach the
 * corners. */
static inline double stp_wanted_radius(bool regular, double area, double reach)
{
    const double side = sqrt(area), most = STP_MERGED_LAMBDA * side;
    return regular ? stp_max(STP_REGULAR_LAMBDA * side, stp_min(most, STP_CORNER_SHARE * reach))
                   : most;
}

/* In a map: the nearest radius, at least `least`, that the codec nearly expects. full: the radius
 * of a disc whose cell is full. */
static inline double stp_radius_on_map(double radius, double full, double least)
{
    double step = round(log2(radius / full) * STP_RADIUS_PARTS);
    while (full * exp2(step / STP_RADIUS_PARTS) < least)
        step += 1.0;
    return full * exp2(step / STP_RADIUS_PARTS);
}

/* In an image whose holes need not stay open: the nearest radius of the grid that is at least
 * `reach`. alone: the sample is merged with no other. Its radius, which is on a finer grid, does
 * not shrink. */
static inline double stp_radius_on_image(double radius, double reach, bool alone)
{
    const double rounding = 1e-3;
    return stp_radius_on_grid(radius, alone ? (1.0 - rounding) * radius : reach, STP_RADIUS_PARTS);
}

#endif
