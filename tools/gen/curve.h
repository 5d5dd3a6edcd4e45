/* The curves and permutations of the sampler: Hilbert's curve in space, Sierpinski's in a triangle,
 * a keyed permutation of [0, count). */
#ifndef STP_TOOLS_GEN_CURVE_H
#define STP_TOOLS_GEN_CURVE_H

#include <stdint.h>

/* The place along a Hilbert curve with 21 bits per axis (63 bits). */
uint64_t gen_hilbert_index(const uint32_t position[3]);

/* Barycentric coordinates of the place t in [0, 1) on the curve that fills a triangle from its
 * first to its third corner. Equal lengths of t fill equal areas. Source: Sierpinski 1912; here the
 * triangle is halved again and again. */
void gen_sierpinski_point(double t, float barycentric[3]);

/* A bijection of [0, count) keyed by seed. */
typedef struct gen_permutation {
    uint64_t count, seed;
    unsigned low_bits, high_bits;
} gen_permutation;

void gen_permutation_init(gen_permutation *permutation, uint64_t count, uint64_t seed);
uint64_t gen_permutation_at(const gen_permutation *permutation, uint64_t index);

#endif
