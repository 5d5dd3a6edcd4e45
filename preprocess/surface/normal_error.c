/* How exact fitted normals are. */
#include "preprocess/surface/normal_error.h"

#include "formats/chunk/sample/normal_grid.h"

#include <math.h>

#define LEAST_OCTAVE (-14.0)
#define BINS_BY_OCTAVE 4.0
/* The greatest angle of the grid over the standard error of normals. The deviation of rounding is
 * about 0.45 of that angle, so rounding makes normals wrong by a third more at most, and by less
 * where they are averaged for a picture. */
#define GRID_SHARE 2.0
#define QUIET_BITS 9u

/* A plane through n points with noise of deviation s has slopes with the standard error s / sqrt(n
 * v) along each axis; v is the variance of the points along the axis, here the mean of both. */
void stp_normal_errors_add(stp_normal_errors *errors, const stp_moments *m, float noise)
{
    const stp_float4 *r = m->row;
    const float n = r[3][3];
    float spread = 0.0f;
    for (int i = 0; i < 3; i++)
        spread += r[i][i] - r[3][i] * r[3][i] / n;
    const double slope = 2.0 * (double)noise / (double)(spread - n * noise);
    const double bin = (0.5 * log2(slope) - LEAST_OCTAVE) * BINS_BY_OCTAVE;
    if (bin != bin) /* no plane */
        return;
    errors->counts[(unsigned)fmin(fmax(bin, 0.0), STP_NORMAL_ERROR_BINS - 1)]++;
}

double stp_normal_errors_median(const stp_normal_errors *errors)
{
    uint64_t sum = 0, below = 0;
    unsigned bin = 0;
    for (unsigned i = 0; i < STP_NORMAL_ERROR_BINS; i++)
        sum += errors->counts[i];
    if (sum == 0)
        return 0.0;
    while (2 * (below + errors->counts[bin]) <= sum)
        below += errors->counts[bin++];
    return exp2(LEAST_OCTAVE + (bin + 0.5) / BINS_BY_OCTAVE);
}

unsigned stp_normal_bits_for(double error, bool quiet)
{
    const unsigned least = quiet ? QUIET_BITS : STP_NORMAL_BITS_LEAST;
    unsigned bits = STP_NORMAL_BITS;
    while (bits > least && stp_normal_grid_angle(bits - 1) <= GRID_SHARE * error)
        bits--;
    return bits;
}

unsigned stp_normal_step_for(double error, bool quiet)
{
    const unsigned bits = stp_normal_bits_for(error, quiet);
    const unsigned whole = stp_normal_bits_step(bits);
    unsigned out = whole;
    if (bits == (quiet ? QUIET_BITS : STP_NORMAL_BITS_LEAST))
        return out;
    for (unsigned odd = 1; odd <= STP_NORMAL_ODD_MOST; odd++)
        for (unsigned step = 2 * odd + 1; step < 2 * whole; step *= 2)
            if (step > out && stp_normal_step_angle(step) <= GRID_SHARE * error)
                out = step;
    return out;
}
