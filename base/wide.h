/* Loops over lanes compiled twice: eight floats an instruction where the processor has AVX2, found
 * out when the program starts, else four. Both give the same bytes: no step is fused, and lanes are
 * joined by greatest, least and bits alone, never by a sum. */
#ifndef STP_BASE_WIDE_H
#define STP_BASE_WIDE_H

/* Sanitizers are not ready yet when the choice is made. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) &&       \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define STP_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define STP_WIDE
#endif

#endif
