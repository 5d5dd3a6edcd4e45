/* Compiles loops over lanes twice: for AVX2 (eight floats per instruction) and for the baseline
 * (four). The program picks one when it starts. Both give the same bytes: no step is fused, and
 * lanes are combined by maximum, minimum and bits only, never by a sum. */
#ifndef STP_BASE_WIDE_H
#define STP_BASE_WIDE_H

#include <limits.h> /* tells whether this is glibc */

/* The choice is made before sanitizers are ready, so they get the baseline only. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) &&       \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define STP_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define STP_WIDE
#endif

#endif
