/* Decodes records of an Entwine Point Tile set's schema. */
#include "formats/scan/octree/ept_records.h"

#include "formats/scan/las/las_bytes.h"
#include "formats/scan/value_range.h"

#include <math.h>

/* LAS's flag in ClassFlags. */
#define FLAG_WITHHELD 0x04u

/* The bytes of a field as a number of two's complement, or without a sign. */
static uint64_t bits_of(const unsigned char *at, unsigned bytes, bool is_signed)
{
    uint64_t bits = 0;
    for (unsigned i = 0; i < bytes; i++)
        bits |= (uint64_t)at[i] << (8 * i);
    if (is_signed && bytes < 8 && at[bytes - 1] & 0x80)
        bits |= UINT64_MAX << (8 * bytes);
    return bits;
}

static double value_of(const stp_ept_field *f, const unsigned char *record)
{
    const unsigned char *at = record + f->at;
    double value;
    if (f->type == STP_EPT_FLOAT && f->bytes == 4) {
        const uint32_t bits = stp_las_u32(at);
        float narrow;
        memcpy(&narrow, &bits, sizeof narrow);
        value = (double)narrow;
    } else if (f->type == STP_EPT_FLOAT) {
        value = stp_las_double(at);
    } else {
        const uint64_t bits = bits_of(at, f->bytes, f->type == STP_EPT_SIGNED);
        value = f->type == STP_EPT_SIGNED ? (double)(int64_t)bits : (double)bits;
    }
    return value * f->scale + f->offset;
}

/* A field as a whole number from 0 to 65535; 0 if the set has no such field. */
static uint16_t number_of(const stp_ept_header *h, stp_ept_role role, const unsigned char *record)
{
    if (!stp_ept_has(h, role))
        return 0;
    return (uint16_t)(stp_value_clamp(value_of(&h->fields[role], record), 65535.0) + 0.5);
}

void stp_ept_records_look(stp_las_seen *seen, const stp_ept_header *h, const unsigned char *records,
                          size_t count)
{
    for (size_t i = 0; i < count; i++, records += h->record_bytes) {
        const uint16_t intensity = number_of(h, STP_EPT_INTENSITY, records);
        if (intensity > seen->intensity_max)
            seen->intensity_max = intensity;
        for (unsigned k = 0; k < 3 && stp_ept_has_colours(h); k++) {
            const uint16_t value = number_of(h, (stp_ept_role)(STP_EPT_RED + k), records);
            if (value > seen->colour_max)
                seen->colour_max = value;
            if (UINT16_MAX - value > seen->colour_gap)
                seen->colour_gap = (uint16_t)(UINT16_MAX - value);
            seen->colour_low |= (uint8_t)(value & 0xff);
        }
    }
}

/* The unit normal, or zero if the record has none. */
static vec3s normal_of(const stp_ept_header *h, const unsigned char *record)
{
    double n[3], square = 0.0;
    for (unsigned k = 0; k < 3; k++) {
        n[k] = value_of(&h->fields[STP_EPT_NORMAL_X + k], record);
        square += n[k] * n[k];
    }
    const double length = sqrt(square);
    if (!(length > 1e-100) || !isfinite(length))
        return (vec3s){{0.0f, 0.0f, 0.0f}};
    return (vec3s){{(float)(n[0] / length), (float)(n[1] / length), (float)(n[2] / length)}};
}

void stp_ept_records_decode(const stp_ept_header *h, const stp_las_depth *depth,
                            const unsigned char *records, stp_point *points, size_t count)
{
    const bool colours = stp_ept_has_colours(h) && depth->colour != STP_LAS_COLOUR_NONE;
    const bool normals = stp_ept_has_normals(h);
    for (size_t i = 0; i < count; i++, records += h->record_bytes) {
        const uint16_t intensity = number_of(h, STP_EPT_INTENSITY, records);
        const bool flagged = number_of(h, STP_EPT_WITHHELD, records) != 0 ||
                             (number_of(h, STP_EPT_CLASS_FLAGS, records) & FLAG_WITHHELD) != 0;
        points[i] = (stp_point){
            .position = {value_of(&h->fields[STP_EPT_X], records),
                         value_of(&h->fields[STP_EPT_Y], records),
                         value_of(&h->fields[STP_EPT_Z], records)},
            .intensity = depth->intensity_8 ? stp_las_widen(intensity) : intensity,
            .class_id = (uint8_t)(number_of(h, STP_EPT_CLASS, records) & 0xff),
            .reject = flagged && !h->keeps_withheld ? STP_REJECT_INVALID : STP_REJECT_NONE};
        for (unsigned k = 0; k < 3 && colours; k++)
            points[i].rgb[k] = stp_las_colour(
                number_of(h, (stp_ept_role)(STP_EPT_RED + k), records), depth->colour);
        if (normals)
            points[i].normal = normal_of(h, records);
    }
}
