/* Finds from the data how many bits the colours and intensities of a LAS file really have.
 *
 * The standard wants 16 bits. Several writers store 0..255 in them, others store 8 bits times 256,
 * or what a camera of 10 or 12 bits gave. The points looked at decide. Colours: all zero, or all
 * white if there are intensities: the file has no colours; up to 255: 8 bits; every low byte zero:
 * 8 bits times 256; up to 1023 or 4095: 10 or 12 bits; else 16 bits. Intensities: up to 255 and not
 * all zero: 8 bits; else 16 bits. Values above the range found are clamped. */
#ifndef STP_FORMATS_SCAN_LAS_LAS_DEPTH_H
#define STP_FORMATS_SCAN_LAS_LAS_DEPTH_H

#include "formats/scan/las/las_header.h"
#include "formats/scan/value_range.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Points are looked at in this many blocks of this many points, spread over the file. All points of
 * a smaller file are looked at. A compressed file has fewer blocks, and each begins where a chunk
 * begins, unless it is not the first of its chunk: a chunk is unpacked from its beginning. */
#define STP_LAS_SAMPLE_BLOCKS 64u
#define STP_LAS_SAMPLE_BLOCKS_COMPRESSED 16u
#define STP_LAS_SAMPLE_POINTS 512u

/* What the points that were looked at have in common. */
typedef struct stp_las_seen {
    uint16_t colour_max, intensity_max;
    uint16_t colour_gap; /* 65535 less the least channel */
    uint8_t colour_low;  /* the low bytes of all colours, ored */
} stp_las_seen;

typedef enum stp_las_colour_depth {
    STP_LAS_COLOUR_NONE,
    STP_LAS_COLOUR_8,
    STP_LAS_COLOUR_8_TIMES_256,
    STP_LAS_COLOUR_10,
    STP_LAS_COLOUR_12,
    STP_LAS_COLOUR_16
} stp_las_colour_depth;

typedef struct stp_las_depth {
    stp_las_colour_depth colour;
    bool intensity_8;
    bool white; /* colours were there, but all white */
} stp_las_depth;

/* Adds count records of the header's length. */
void stp_las_depth_look(stp_las_seen *seen, const stp_las_header *header,
                        const unsigned char *records, size_t count);
stp_las_depth stp_las_depth_decide(const stp_las_seen *seen);

/* File value to 0..65535. */
static inline uint16_t stp_las_widen(uint16_t value)
{
    return value < 255 ? (uint16_t)(value * 257) : (uint16_t)65535;
}

static inline uint16_t stp_las_colour(uint16_t value, stp_las_colour_depth depth)
{
    switch (depth) {
    case STP_LAS_COLOUR_8:
        return stp_las_widen(value);
    case STP_LAS_COLOUR_8_TIMES_256:
        return stp_las_widen(value >> 8);
    case STP_LAS_COLOUR_10:
        return stp_value_range_map(value, 0.0, 65535.0 / 1023.0);
    case STP_LAS_COLOUR_12:
        return stp_value_range_map(value, 0.0, 65535.0 / 4095.0);
    default:
        return value;
    }
}

#endif
