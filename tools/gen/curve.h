/* The curves and permutations behind the sampler: Hilbert's in space, Sierpinski's in a triangle, a
 * keyed permutation of [0, count). */
#ifndef STP_TOOLS_GEN_CURVE_H
#define STP_TOOLS_GEN_CURVE_H

#include <stdint.h>

/* Place along a Hilbert curve of 21 bits an axis (63 bits). */
uint64_t gen_hilbert_index(const uint32_t position[3]);

/* Barycentric coordinates of the place t in [0, 1) of the curve that fills a triangle from its
 * first to its third corner; equal lengths of t fill equal areas. Source: Sierpinski 1912; here the
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
