/* Deterministic random numbers: splitmix64 as a counter-based hash, so that the i-th number needs
 * no state and the same seed gives the same numbers on any number of threads. */
#ifndef STP_BASE_RANDOM_H
#define STP_BASE_RANDOM_H

#include <stdint.h>

/* 64 well-mixed bits of (seed, counter). Source: Steele, Lea, Flood 2014 (splitmix64 finaliser). */
static inline uint64_t stp_random_u64(uint64_t seed, uint64_t counter)
{
    uint64_t z = seed * 0xd1342543de82ef95u + (counter + 1) * 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* Uniform in [0, 1) with 53 random bits. */
static inline double stp_random_unit(uint64_t seed, uint64_t counter)
{
    return (double)(stp_random_u64(seed, counter) >> 11) * 0x1p-53;
}

#endif
