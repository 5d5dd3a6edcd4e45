/* Sublattices of a patch's lattice. */
#include "formats/chunk/sample/sublattice.h"

#include <math.h>

enum { WHOLE, FACE_CENTRED, BODY_CENTRED };

#define SLANTED_COUNT (STP_SLANTED_MOST - STP_SLANTED + 1)
/* Slanted ones have whole numbers up to this near any place's nearest whole numbers. */
#define SLANTED_WAY 2
/* Most that x + 2 y changes by them. */
#define SLANTED_SPAN (3 * SLANTED_WAY)

double stp_sublattice_reach(unsigned sublattice)
{
    static const double slanted[SLANTED_COUNT] = {1.79, 53.0 / 28.0, 2.75, 1451.0 / 484.0};
    static const double squared[STP_SUBLATTICE_KINDS] = {0.75, 1.0, 1.25};
    if (sublattice >= STP_SLANTED)
        return sqrt(slanted[sublattice - STP_SLANTED]);
    return ldexp(sqrt(squared[sublattice % STP_SUBLATTICE_KINDS]),
                 (int)(sublattice / STP_SUBLATTICE_KINDS));
}

unsigned stp_sublattice_quarters(unsigned sublattice)
{
    static const uint8_t slanted[SLANTED_COUNT] = {9, 11, 13, 14};
    return sublattice >= STP_SLANTED ? slanted[sublattice - STP_SLANTED] : 4 * sublattice;
}

unsigned stp_sublattice_within(double reach)
{
    unsigned out = 0;
    while (out < STP_SUBLATTICE_MOST && stp_sublattice_reach(out + 1) <= reach)
        out++;
    for (unsigned s = STP_SLANTED; s <= STP_SLANTED_MOST; s++)
        if (stp_sublattice_reach(s) <= reach &&
            stp_sublattice_quarters(s) > stp_sublattice_quarters(out))
            out = s;
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

/* By x + 2 y + 4 z modulo N, repeated for sums up to SLANTED_SPAN less or more: the least step of z
 * after which the sum is a multiple of N. */
static const int16_t slanted_up[SLANTED_COUNT][STP_SLANTED_PARTS_MOST + 2 * SLANTED_SPAN] = {
    {-1, 0, 1, 2, -2, -1, 0, 1, 2, -2, -1, 0, 1, 2, -2, -1, 0},
    {-2, 3, 1, -1, -3, 2, 0, -2, 3, 1, -1, -3, 2, 0, -2, 3, 1, -1, -3},
    {-3, -1, 1, 3, -4, -2, 0, 2, 4, -3, -1, 1, 3, -4, -2, 0, 2, 4, -3, -1, 1},
    {-4, 4, 1, -2, -5, 3, 0, -3, 5, 2, -1, -4, 4, 1, -2, -5, 3, 0, -3, 5, 2, -1, -4}};

/* Of whole numbers around, for each x and y the z that is right and least far off. None farther off
 * than the sublattice reaches is the nearest. */
static void nearest_slanted(unsigned sublattice, const double place[3], double out[3])
{
    const int16_t *up = slanted_up[sublattice - STP_SLANTED] + SLANTED_SPAN;
    const double reach = stp_sublattice_reach(sublattice);
    double whole[3], off[3], least = reach * reach + 1e-6;
    for (int i = 0; i < 3; i++) {
        whole[i] = floor(place[i] + 0.5);
        off[i] = place[i] - whole[i];
    }
    const int64_t sum = (int64_t)whole[0] + 2 * (int64_t)whole[1] + 4 * (int64_t)whole[2];
    const int32_t parts = stp_slanted_parts(sublattice), odd = (int32_t)(sum % parts);
    const int32_t rest = odd < 0 ? odd + parts : odd;
    for (int x = -SLANTED_WAY; x <= SLANTED_WAY; x++) {
        const double along = (off[0] - x) * (off[0] - x);
        for (int y = -SLANTED_WAY; y <= SLANTED_WAY && along < least; y++) {
            const double aside = along + (off[1] - y) * (off[1] - y);
            if (aside >= least)
                continue;
            const int z = up[rest + x + 2 * y];
            const double far = aside + (off[2] - z) * (off[2] - z);
            if (far >= least)
                continue;
            least = far;
            out[0] = whole[0] + x;
            out[1] = whole[1] + y;
            out[2] = whole[2] + z;
        }
    }
}

void stp_sublattice_nearest(unsigned sublattice, const double place[3], double out[3])
{
    if (sublattice >= STP_SLANTED) {
        nearest_slanted(sublattice, place, out);
        return;
    }
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

/* Whether all samples of a patch are on a slanted sublattice. */
static bool all_slanted(unsigned sublattice, const stp_patch *patch, const stp_sample *samples)
{
    const int32_t parts = stp_slanted_parts(sublattice);
    for (unsigned i = 0; i < patch->counts[0]; i++) {
        const uint16_t *at = samples[i].position;
        const int32_t position[3] = {at[0], at[1], at[2]};
        if (stp_slanted_sum(patch->origin, position) % parts != 0)
            return false;
    }
    return true;
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
    unsigned out = STP_SUBLATTICE_KINDS * octave + kind;
    for (unsigned s = STP_SLANTED; s <= STP_SLANTED_MOST; s++)
        if (stp_sublattice_quarters(s) > stp_sublattice_quarters(out) &&
            all_slanted(s, patch, samples))
            out = s;
    return out;
}

bool stp_sublattice_has(unsigned sublattice, const stp_patch *patch, const stp_sample *samples)
{
    if (sublattice >= STP_SLANTED)
        return all_slanted(sublattice, patch, samples);
    const bits b = bits_of(patch, samples);
    const uint32_t octave = UINT32_C(1) << (sublattice / STP_SUBLATTICE_KINDS);
    const unsigned kind = sublattice % STP_SUBLATTICE_KINDS;
    return !(b.any & (octave - 1)) && !(kind == FACE_CENTRED && b.odd_sum & octave) &&
           !(kind == BODY_CENTRED && b.uneven & octave);
}
