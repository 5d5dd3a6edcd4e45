/* Finds how many bits the colours and intensities of a LAS file really have. */
#include "formats/scan/las/las_depth.h"

#include "formats/scan/las/las_bytes.h"

enum { AT_INTENSITY = 12 };

void stp_las_depth_look(stp_las_seen *seen, const stp_las_header *header,
                        const unsigned char *records, size_t count)
{
    for (size_t i = 0; i < count; i++, records += header->record_bytes) {
        const uint16_t intensity = stp_las_u16(records + AT_INTENSITY);
        if (intensity > seen->intensity_max)
            seen->intensity_max = intensity;
        for (unsigned k = 0; k < 3 && header->format->rgb > 0; k++) {
            const uint16_t value = stp_las_u16(records + header->format->rgb + 2 * k);
            if (value > seen->colour_max)
                seen->colour_max = value;
            if (UINT16_MAX - value > seen->colour_gap)
                seen->colour_gap = (uint16_t)(UINT16_MAX - value);
            seen->colour_low |= (uint8_t)(value & 0xff);
        }
    }
}

stp_las_depth stp_las_depth_decide(const stp_las_seen *seen)
{
    stp_las_depth depth = {.intensity_8 = seen->intensity_max > 0 && seen->intensity_max <= 255};
    depth.white = seen->intensity_max > 0 &&
                  stp_value_is_white(UINT16_MAX - seen->colour_gap, seen->colour_max);
    if (seen->colour_max == 0 || depth.white)
        depth.colour = STP_LAS_COLOUR_NONE;
    else if (seen->colour_max <= 255)
        depth.colour = STP_LAS_COLOUR_8;
    else if (seen->colour_low == 0)
        depth.colour = STP_LAS_COLOUR_8_TIMES_256;
    else if (seen->colour_max <= 1023)
        depth.colour = STP_LAS_COLOUR_10;
    else
        depth.colour = seen->colour_max <= 4095 ? STP_LAS_COLOUR_12 : STP_LAS_COLOUR_16;
    return depth;
}
