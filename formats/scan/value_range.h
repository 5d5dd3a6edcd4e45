/* Maps intensities, colours and classes of any range to the range of stp_point.
 *
 * The file says what a value means. If it does not, the greatest value of a sample of records,
 * spread over the file, decides: 8-bit whole numbers are 8-bit; floats up to 1 are fractions; other
 * values up to 255 are 8-bit values that were stored wide; all others are 16-bit, but colours up to
 * 1023 or 4095 are those of a camera of 10 or 12 bits, and colours up to 1 are fractions in any
 * type. Threads: any. */
#ifndef STP_FORMATS_SCAN_VALUE_RANGE_H
#define STP_FORMATS_SCAN_VALUE_RANGE_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Values from low to high map to 0..65535; high > low. */
typedef struct stp_value_range {
    double low, high;
} stp_value_range;

/* Guesses the range from the type of a value and the greatest value of a sample. */
static inline stp_value_range stp_value_range_guess(bool is_float, unsigned bytes, double maximum)
{
    double high = 65535.0;
    /* If all values are zero, believe the type: a 16-bit type is 16-bit. */
    const bool claims_16_bits = !is_float && bytes == 2;
    if (is_float && maximum <= 1.0)
        high = 1.0;
    else if (bytes == 1 || (maximum <= 255.0 && !(maximum <= 0.0 && claims_16_bits)))
        high = 255.0;
    return (stp_value_range){0.0, high};
}

/* Floats up to this are fractions whose full is 1: brighter ones overshoot, as those of renderers.
 */
#define STP_COLOUR_OVERSHOOT 4.0

/* The same for colours. */
static inline stp_value_range stp_value_range_guess_colour(bool is_float, unsigned bytes,
                                                           double maximum)
{
    stp_value_range range = stp_value_range_guess(is_float, bytes, maximum);
    if (maximum > 0.0 && maximum <= (is_float ? STP_COLOUR_OVERSHOOT : 1.0))
        range.high = 1.0;
    if (range.high > 255.0 && maximum > 255.0 && maximum <= 4095.0)
        range.high = maximum <= 1023.0 ? 1023.0 : 4095.0;
    return range;
}

/* The values of a sample. Starts zeroed. */
typedef struct stp_value_span {
    double min, max; /* of finite ones and 0 */
    bool fractions;  /* some value is not whole */
} stp_value_span;

static inline void stp_value_span_add(stp_value_span *span, double value)
{
    if (!isfinite(value))
        return;
    span->min = fmin(span->min, value);
    span->max = fmax(span->max, value);
    span->fractions = span->fractions || floor(value) != value;
}

/* The same for intensities. Negative ones: whole numbers of 12 bits are those of Leica's scanners,
 * others, such as decibels, reach from the least to the greatest. */
static inline stp_value_range stp_value_range_guess_intensity(bool is_float, unsigned bytes,
                                                              stp_value_span span)
{
    if (span.min < 0.0 && !span.fractions && span.min >= -2048.0 && span.max <= 2047.0)
        return (stp_value_range){-2048.0, 2047.0};
    if (span.min < 0.0)
        return (stp_value_range){span.min, span.max > span.min ? span.max : span.min + 65535.0};
    if (span.max > 65535.0)
        return (stp_value_range){0.0, span.max};
    return stp_value_range_guess(is_float, bytes, span.max);
}

/* Whether colours whose channels are all within least..greatest are white: where there are
 * intensities, a program wrote them for want of any. */
static inline bool stp_value_is_white(double least, double greatest)
{
    return least == greatest &&
           (greatest == 1.0 || greatest == 255.0 || greatest == 65535.0 || greatest == 65280.0);
}

/* The range that holds both. */
static inline stp_value_range stp_value_range_join(stp_value_range a, stp_value_range b)
{
    return (stp_value_range){fmin(a.low, b.low), fmax(a.high, b.high)};
}

/* Range of stp_point per unit of value; exact for 0..1, 0..255 and 0..65535. */
static inline double stp_value_range_scale(stp_value_range range)
{
    return 65535.0 / (range.high - range.low);
}

/* NaN and negative values become 0, values above maximum become maximum. */
static inline double stp_value_clamp(double value, double maximum)
{
    return value > 0.0 ? fmin(value, maximum) : 0.0;
}

/* scale is stp_value_range_scale of the range. */
static inline uint16_t stp_value_range_map(double value, double low, double scale)
{
    return (uint16_t)(stp_value_clamp((value - low) * scale, 65535.0) + 0.5);
}

static inline uint8_t stp_class_of(double value)
{
    return (uint8_t)(stp_value_clamp(value, 255.0) + 0.5);
}

/* The first record of the given block, if `blocks` blocks are spread over `total` records. total
 * may be any number that a file gives. */
static inline uint64_t stp_spread_begin(uint64_t total, uint64_t block, uint64_t blocks)
{
    /* Divide first: for a hostile total the product would overflow. */
    return total / blocks * block + total % blocks * block / blocks;
}

#endif
