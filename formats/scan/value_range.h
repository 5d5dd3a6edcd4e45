/* Intensities, colours and classes of any range, brought to what points have; told from a look at
 * records spread over the file.
 *
 * What a value means is said by the file, or told from the greatest of a sample: whole numbers of 8
 * bits are what they are; floats up to 1 are fractions; any values up to 255 are 8-bit ones that
 * were stored wide; others are taken as 16-bit. Threads: any. */
#ifndef STP_FORMATS_SCAN_VALUE_RANGE_H
#define STP_FORMATS_SCAN_VALUE_RANGE_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Values from low to high > low stand for 0 to 65535. */
typedef struct stp_value_range {
    double low, high;
} stp_value_range;

/* By the type of a value and the greatest of a sample. */
static inline stp_value_range stp_value_range_guess(bool is_float, unsigned bytes, double maximum)
{
    double high = 65535.0;
    /* Nothing but zeros says nothing: then a 16-bit type is what it claims to be. */
    const bool claims_16_bits = !is_float && bytes == 2;
    if (is_float && maximum <= 1.0)
        high = 1.0;
    else if (bytes == 1 || (maximum <= 255.0 && !(maximum <= 0.0 && claims_16_bits)))
        high = 255.0;
    return (stp_value_range){0.0, high};
}

/* The range that holds both. */
static inline stp_value_range stp_value_range_join(stp_value_range a, stp_value_range b)
{
    return (stp_value_range){fmin(a.low, b.low), fmax(a.high, b.high)};
}

/* What a difference in value is worth: exact for 0..1, 0..255 and 0..65535. */
static inline double stp_value_range_scale(stp_value_range range)
{
    return 65535.0 / (range.high - range.low);
}

/* NaN and negative become 0, what is too great the maximum. */
static inline double stp_value_clamp(double value, double maximum)
{
    return value > 0.0 ? fmin(value, maximum) : 0.0;
}

/* scale is the range's. */
static inline uint16_t stp_value_range_map(double value, double low, double scale)
{
    return (uint16_t)(stp_value_clamp((value - low) * scale, 65535.0) + 0.5);
}

static inline uint8_t stp_class_of(double value)
{
    return (uint8_t)(stp_value_clamp(value, 255.0) + 0.5);
}

/* Where a look at `blocks` places spread over `total` records begins its nth; total may be any
 * number that a file gives. */
static inline uint64_t stp_spread_begin(uint64_t total, uint64_t block, uint64_t blocks)
{
    /* Divided first: the product of a hostile total would overflow. */
    return total / blocks * block + total % blocks * block / blocks;
}

#endif
