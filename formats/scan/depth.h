/* File values of colours and intensities to the 16 bits that points have. Threads: any. */
#ifndef STP_FORMATS_SCAN_DEPTH_H
#define STP_FORMATS_SCAN_DEPTH_H

#include <math.h>
#include <stdint.h>

/* NaN and negative become 0, what is too great the maximum. */
static inline double stp_clamp_value(double value, double maximum)
{
    return value > 0.0 ? fmin(value, maximum) : 0.0;
}

static inline uint16_t stp_to_16_bits(double value, double scale)
{
    return (uint16_t)(stp_clamp_value(value * scale, 65535.0) + 0.5);
}

static inline uint8_t stp_to_class(double value)
{
    return (uint8_t)(stp_clamp_value(value, 255.0) + 0.5);
}

#endif
