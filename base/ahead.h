/* Asks the memory for what a loop over points will read soon.
 *
 * Points along the Morton curve have most of their neighbours a little farther on in all arrays,
 * too far for what processors fetch by themselves. */
#ifndef STP_BASE_AHEAD_H
#define STP_BASE_AHEAD_H

#include <stddef.h>
#include <stdint.h>

/* How far ahead, in elements. */
#define STP_AHEAD 256u

/* Call it at element i of an array. Nothing happens if the array ends before. */
static inline void stp_ask_ahead(const void *array, size_t size, size_t i)
{
    const uintptr_t at = (uintptr_t)array + size * (i + STP_AHEAD);
    __builtin_prefetch((const void *)at, 0, 2);
}

#endif
