/* Sublattices: a patch's positions of level 0 may lie on a coarser lattice than the patch's, where
 * that is still within the error that a writer allows itself.
 *
 * Sublattice 3 j + r has a (3 j + r)-bit part of the patch's lattice. Its points are 2^j times
 * those of the whole numbers (r = 0), of a face-centred cubic lattice (r = 1: the sum of the
 * coordinates is even) or of a body-centred one (r = 2: all coordinates are even, or all odd).
 * These three are the best between one octave and the next: no place is farther from the lattice
 * than sqrt(3)/2, 1 and sqrt(5)/2 times 2^j (Conway and Sloane, "Sphere packings, lattices and
 * groups", chapter 2). Slanted ones, 15 to 18, have an N-th part, N = 5, 7, 9, 11: their points are
 * whole numbers x, y, z with x + 2 y + 4 z a multiple of N. Among lattices of this kind they reach
 * least. Coordinates are steps of the patch's lattice from the chunk's origin.
 * Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_SAMPLE_SUBLATTICE_H
#define STP_FORMATS_CHUNK_SAMPLE_SUBLATTICE_H

#include "formats/chunk/chunk_file.h"

/* The last one of octaves: r = 2, j = 4. */
#define STP_SUBLATTICE_MOST 14u
#define STP_SUBLATTICE_KINDS 3u
/* The first and the last slanted one. */
#define STP_SLANTED 15u
#define STP_SLANTED_MOST 18u

/* The greatest distance of any place from the sublattice, in steps. */
double stp_sublattice_reach(unsigned sublattice);
/* The coarsest sublattice that reaches no farther than `reach` steps. */
unsigned stp_sublattice_within(double reach);
/* How many bits of a place a sublattice leaves out, in quarters. */
unsigned stp_sublattice_quarters(unsigned sublattice);
/* The point of a sublattice that is nearest to a place, in steps; |place| < 2^52. */
void stp_sublattice_nearest(unsigned sublattice, const double place[3], double out[3]);
/* The coarsest sublattice that has all samples of level 0 of a patch. */
unsigned stp_sublattice_of(const stp_patch *patch, const stp_sample *samples);
/* Whether a sublattice has all of them. */
bool stp_sublattice_has(unsigned sublattice, const stp_patch *patch, const stp_sample *samples);

/* N of a slanted sublattice, and the greatest. */
#define STP_SLANTED_PARTS_MOST 11
static inline int32_t stp_slanted_parts(unsigned sublattice)
{
    return (int32_t)(2 * (sublattice - STP_SLANTED) + 5);
}

/* x + 2 y + 4 z of a position, from the chunk's origin. origin: of the patch. */
static inline int64_t stp_slanted_sum(const int32_t origin[3], const int32_t position[3])
{
    return ((int64_t)origin[0] + position[0]) + 2 * ((int64_t)origin[1] + position[1]) +
           4 * ((int64_t)origin[2] + position[2]);
}

/* On a slanted sublattice: the least number, 0 to N - 1, that is right along an axis if the sum is
 * `sum` with 0 there. */
static inline int32_t stp_slanted_offset(unsigned sublattice, int axis, int64_t sum)
{
    /* N - 1 / 2^axis modulo N */
    static const uint8_t less[STP_SLANTED_MOST - STP_SLANTED + 1][3] = {
        {4, 2, 1}, {6, 3, 5}, {8, 4, 2}, {10, 5, 8}};
    const int32_t parts = stp_slanted_parts(sublattice);
    const int32_t rest = (int32_t)(sum % parts) + parts;
    return rest * less[sublattice - STP_SLANTED][axis] % parts;
}

/* A coordinate of a position is offset + place * 2^shift, modulo 2^16. The offset follows from the
 * coordinates before it. */
typedef struct stp_sublattice_axis {
    unsigned shift;
    int32_t offset;
} stp_sublattice_axis;

/* The axis of a sublattice of octaves, of the i-th coordinate that is coded; the bits that count of
 * those before, from the chunk's origin: their sum for r = 1, that of the first for r = 2. origin:
 * of the patch along the axis. */
static inline stp_sublattice_axis stp_sublattice_axis_of(unsigned sublattice, int i,
                                                         uint32_t before, int32_t origin)
{
    const unsigned octave = sublattice / STP_SUBLATTICE_KINDS;
    const unsigned kind = sublattice % STP_SUBLATTICE_KINDS;
    const unsigned odd = kind != 0 && i + (int)kind > 2;
    const uint32_t bits = odd ? before & (UINT32_C(1) << octave) : 0;
    const uint32_t mask = (UINT32_C(2) << octave) - 1;
    return (stp_sublattice_axis){octave + odd, (int32_t)((bits - (uint32_t)origin) & mask)};
}

#endif
