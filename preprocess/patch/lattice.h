/* Lattices and radii that follow from the sampling. Pure functions. Threads: any. */
#ifndef STP_PREPROCESS_PATCH_LATTICE_H
#define STP_PREPROCESS_PATCH_LATTICE_H

#include "base/vec.h"

#include <math.h>

/* Floor of the binary logarithm of a positive, finite value. */
static inline int stp_floor_log2(double value)
{
    int exponent = 0;
    (void)frexp(value, &exponent);
    return exponent - 1;
}

/* A sample's position error is at most the local spacing over this. */
#define STP_SPACING_PARTS 32.0

/* No lattice is coarser than 2^STP_LATTICE_MAX. */
#define STP_LATTICE_MAX 160

/* The exponent of the lattice for a position: the greatest with
 *
 *     sqrt(3)/2 2^exponent <= spacing / STP_SPACING_PARTS, and <= precision if that is positive
 *
 * If the disc's radius has no code on that lattice, the finest lattice where it has one. That
 * happens only if the lattice is some ten thousand times finer than the sampling. */
int stp_lattice_exponent(double spacing, double radius, double precision, stp_dvec3 position);

/* Radii are rounded to this many an octave, from powers of two on. The mean distance of 16 points
 * tells a spacing to an eighth, so finer steps would be noise. */
#define STP_RADII_BY_OCTAVE 4.0
/* The nearest radius of a grid of so many an octave that is not less than `least`. */
double stp_radius_on_grid(double radius, double least, double by_octave);

/* The exponent of the lattice of a patch vertex, which is also a sample of the parent. It follows
 * the sum of the items' areas. It is coarse enough to give a ball of radius `reach` a code, and no
 * finer than `finest`. It grows with each of the three. */
int stp_vertex_exponent(double area, double reach, int finest);

#endif
