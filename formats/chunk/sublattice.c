/* Sublattices of a patch's lattice. */
#include "formats/chunk/sublattice.h"

#include <math.h>

enum { WHOLE, FACE_CENTRED, BODY_CENTRED };

double stp_sublattice_reach(unsigned sublattice)
{
    static const double squared[STP_SUBLATTICE_KINDS] = {0.75, 1.0, 1.25};
    return ldexp(sqrt(squared[sublattice % STP_SUBLATTICE_KINDS]),
                 (int)(sublattice / STP_SUBLATTICE_KINDS));
}

unsigned stp_sublattice_within(double reach)
{
    unsigned out = 0;
    while (out < STP_SUBLATTICE_MOST && stp_sublattice_reach(out + 1) <= reach)
        out++;
    return out;
}

/* The nearest point with all coordinates even, if odd = 0, or odd, if 1. Returns the squared
 * distance. */
static double nearest_even(const double place[3], double odd, double out[3])
{
    double sum = 0.0;
    for (int i = 0; i < 3; i++) {
        out[i] = 2.0 * floor((place[i] - odd) / 2.0 + 0.5) + odd;
        sum += (place[i] - out[i]) * (place[i] - out[i]);
    }
    return sum;
}

/* The nearest whole numbers whose sum is even: if that of the nearest ones is odd, the coordinate
 * that is farthest from its number takes the second nearest. */
static void nearest_even_sum(const double place[3], double out[3])
{
    int farthest = 0;
    for (int i = 0; i < 3; i++) {
        out[i] = floor(place[i] + 0.5);
        if (fabs(place[i] - out[i]) > fabs(place[farthest] - out[farthest]))
            farthest = i;
    }
    if (fmod(out[0] + out[1] + out[2], 2.0) != 0.0)
        out[farthest] += place[farthest] < out[farthest] ? -1.0 : 1.0;
}

void stp_sublattice_nearest(unsigned sublattice, const double place[3], double out[3])
{
    const int octave = (int)(sublattice / STP_SUBLATTICE_KINDS);
    const unsigned kind = sublattice % STP_SUBLATTICE_KINDS;
    double scaled[3], other[3];
    for (int i = 0; i < 3; i++)
        scaled[i] = ldexp(place[i], -octave);
    for (int i = 0; i < 3 && kind == WHOLE; i++)
        out[i] = floor(scaled[i] + 0.5);
    if (kind == FACE_CENTRED)
        nearest_even_sum(scaled, out);
    const bool odd =
        kind == BODY_CENTRED && nearest_even(scaled, 0.0, out) > nearest_even(scaled, 1.0, other);
    for (int i = 0; i < 3; i++)
        out[i] = ldexp(odd ? other[i] : out[i], octave);
}

/* Bits of coordinates, from the chunk's origin, of level 0 of a patch. */
typedef struct bits {
    uint32_t any;     /* set in any coordinate */
    uint32_t uneven;  /* that differ from axis to axis */
    uint32_t odd_sum; /* of sums of the three, as far as lower ones are 0 */
} bits;

static bits bits_of(const stp_patch *patch, const stp_sample *samples)
{
    bits out = {0};
    for (unsigned i = 0; i < patch->counts[0]; i++) {
        uint32_t at[3];
        for (int a = 0; a < 3; a++)
            at[a] = (uint32_t)patch->origin[a] + samples[i].position[a];
        out.any |= at[0] | at[1] | at[2];
        out.uneven |= (at[0] ^ at[1]) | (at[0] ^ at[2]);
        out.odd_sum |= at[0] ^ at[1] ^ at[2];
    }
    return out;
}

unsigned stp_sublattice_of(const stp_patch *patch, const stp_sample *samples)
{
    const bits b = bits_of(patch, samples);
    const uint32_t most = UINT32_C(1) << (STP_SUBLATTICE_MOST / STP_SUBLATTICE_KINDS);
    const unsigned octave = (unsigned)__builtin_ctz(b.any | most);
    unsigned kind = WHOLE;
    if (!(b.uneven >> octave & 1u))
        kind = BODY_CENTRED;
    else if (!(b.odd_sum >> octave & 1u))
        kind = FACE_CENTRED;
    return STP_SUBLATTICE_KINDS * octave + kind;
}

bool stp_sublattice_has(unsigned sublattice, const stp_patch *patch, const stp_sample *samples)
{
    const bits b = bits_of(patch, samples);
    const uint32_t octave = UINT32_C(1) << (sublattice / STP_SUBLATTICE_KINDS);
    const unsigned kind = sublattice % STP_SUBLATTICE_KINDS;
    return !(b.any & (octave - 1)) && !(kind == FACE_CENTRED && b.odd_sum & octave) &&
           !(kind == BODY_CENTRED && b.uneven & octave);
}
