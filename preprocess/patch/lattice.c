/* Chooses lattices and radii by the sampling. */
#include "preprocess/patch/lattice.h"

#define LATTICE_MIN (-160)
/* A bound below 2^(BOUND_OCTAVES + 1) steps has a code. */
#define BOUND_OCTAVES 14

int stp_lattice_exponent(double spacing, double radius, double precision, stp_dvec3 position)
{
    /* half a cell's diagonal, sqrt(3)/2 steps, is the greatest position error */
    double step = spacing / STP_SPACING_PARTS * 2.0 / sqrt(3.0);
    if (precision > 0.0)
        step =
            step > 0.0 ? stp_min(step, precision * 2.0 / sqrt(3.0)) : precision * 2.0 / sqrt(3.0);
    double size = stp_max(fabs(position.x), stp_max(fabs(position.y), fabs(position.z)));
    if (!(step > 0.0)) /* all at one place: a float's resolution */
        step = size > 0.0 ? ldexp(size, -24) : 1.0;
    int exponent = stp_floor_log2(step);
    if (radius > 0.0 && stp_floor_log2(radius) - BOUND_OCTAVES > exponent)
        exponent = stp_floor_log2(radius) - BOUND_OCTAVES;
    return exponent < LATTICE_MIN       ? LATTICE_MIN
           : exponent > STP_LATTICE_MAX ? STP_LATTICE_MAX
                                        : exponent;
}

int stp_vertex_exponent(double area, double reach, int finest)
{
    const double step = sqrt(area) / STP_SPACING_PARTS * 2.0 / sqrt(3.0);
    if (step > 0.0 && stp_floor_log2(step) > finest)
        finest = stp_floor_log2(step);
    if (reach > 0.0 && stp_floor_log2(reach) - BOUND_OCTAVES > finest)
        finest = stp_floor_log2(reach) - BOUND_OCTAVES;
    return finest;
}

double stp_radius_on_grid(double radius, double least, double by_octave)
{
    if (!(radius > 0.0))
        return radius;
    const double octave = stp_floor_log2(radius);
    double step = round((log2(radius) - octave) * by_octave);
    while (exp2(octave + step / by_octave) < least)
        step += 1.0;
    return exp2(octave + step / by_octave);
}
