/* Numbers of a clock: they lie on multiples of a step that is no whole number.
 *
 * A scanner's times are ticks of a clock, and it sends its pulses at a steady rate, so the
 * difference of two times is about m pulses. The parts of a difference are small where the
 * difference itself is not. formats/SPEC.md, "Numbers of an attribute", has the arithmetic.
 * Threads: any. */
#ifndef STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_STEPS_H
#define STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_STEPS_H

#include "base/error.h"

#include <stdbool.h>
#include <stdint.h>

#define STP_STEPS_LIMIT 2u
/* The greatest step. The least is 1. */
#define STP_STEP_MOST 0x1p40

/* Zero: no steps. of[0] counts in numbers, of[1] in steps of of[0]. */
typedef struct stp_steps {
    unsigned count;
    unsigned decimals; /* of the numbers that the steps were found in; not stored with them */
    double of[STP_STEPS_LIMIT];
} stp_steps;

/* Finds the steps of most numbers, if there are some. Changes the numbers; out->decimals stays.
 * Errors: OUT_OF_MEMORY. */
stp_status stp_steps_find(int64_t *numbers, uint32_t count, stp_steps *out, stp_error *err);

/* Parts a difference: out[0] numbers, out[1] steps of of[0], and so on: count + 1 parts. */
void stp_steps_part(const stp_steps *steps, int64_t difference, int64_t *out);
/* The inverse. False if the parts are greater than any difference. */
bool stp_steps_join(const stp_steps *steps, const int64_t *parts, int64_t *out);

static inline bool stp_step_is_valid(double step)
{
    return step >= 1.0 && step <= STP_STEP_MOST;
}

#endif
