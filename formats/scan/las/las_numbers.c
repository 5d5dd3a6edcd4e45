/* The attributes of LAS points, and where they lie in a record. */
#include "formats/scan/las/las_numbers.h"

#include "formats/scan/las/las_bytes.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Layout of a description of extra bytes. */
enum {
    EXTRA_BYTES = 192,
    AT_EXTRA_TYPE = 2,
    AT_EXTRA_OPTIONS = 3,
    AT_EXTRA_NAME = 4,
    EXTRA_NAME_BYTES = 32,
    AT_EXTRA_SCALE = 112,
    AT_EXTRA_OFFSET = 136
};
#define OPTION_SCALE 8u
#define OPTION_OFFSET 16u
/* A step of the scan angle in formats from 6 on, degrees. */
#define ANGLE_STEP 0.006

/* A field that a kind of format has. */
typedef struct known_field {
    const char *name;
    stp_attribute_type type;
    stp_las_field field;
    double scale;
} known_field;

/* Formats 0 to 5. */
static const known_field legacy_fields[] = {
    {"intensity", STP_ATTRIBUTE_U16, {12, 0, 0}, 1.0},
    {"return_number", STP_ATTRIBUTE_U8, {14, 0, 3}, 1.0},
    {"number_of_returns", STP_ATTRIBUTE_U8, {14, 3, 3}, 1.0},
    {"scan_direction_flag", STP_ATTRIBUTE_U8, {14, 6, 1}, 1.0},
    {"edge_of_flight_line", STP_ATTRIBUTE_U8, {14, 7, 1}, 1.0},
    {"synthetic", STP_ATTRIBUTE_U8, {15, 5, 1}, 1.0},
    {"key_point", STP_ATTRIBUTE_U8, {15, 6, 1}, 1.0},
    {"scan_angle_rank", STP_ATTRIBUTE_I8, {16, 0, 0}, 1.0},
    {"user_data", STP_ATTRIBUTE_U8, {17, 0, 0}, 1.0},
    {"point_source_id", STP_ATTRIBUTE_U16, {18, 0, 0}, 1.0},
};

/* Formats from 6 on. */
static const known_field extended_fields[] = {
    {"intensity", STP_ATTRIBUTE_U16, {12, 0, 0}, 1.0},
    {"return_number", STP_ATTRIBUTE_U8, {14, 0, 4}, 1.0},
    {"number_of_returns", STP_ATTRIBUTE_U8, {14, 4, 4}, 1.0},
    {"synthetic", STP_ATTRIBUTE_U8, {15, 0, 1}, 1.0},
    {"key_point", STP_ATTRIBUTE_U8, {15, 1, 1}, 1.0},
    {"overlap", STP_ATTRIBUTE_U8, {15, 3, 1}, 1.0},
    {"scanner_channel", STP_ATTRIBUTE_U8, {15, 4, 2}, 1.0},
    {"scan_direction_flag", STP_ATTRIBUTE_U8, {15, 6, 1}, 1.0},
    {"edge_of_flight_line", STP_ATTRIBUTE_U8, {15, 7, 1}, 1.0},
    {"user_data", STP_ATTRIBUTE_U8, {17, 0, 0}, 1.0},
    {"scan_angle", STP_ATTRIBUTE_I16, {18, 0, 0}, ANGLE_STEP},
    {"point_source_id", STP_ATTRIBUTE_U16, {20, 0, 0}, 1.0},
};

stp_attribute *stp_las_numbers_add(stp_las_numbers *out, const char *name, stp_attribute_type type,
                                   stp_las_field field, double scale)
{
    if (out->list.count == STP_ATTRIBUTES_LIMIT ||
        stp_attribute_find(&out->list, name) != UINT32_MAX)
        return NULL;
    stp_attribute *a = &out->list.items[out->list.count];
    *a = (stp_attribute){.type = type, .scale = scale};
    snprintf(a->name, sizeof a->name, "%s", name);
    out->fields[out->list.count++] = field;
    return a;
}

void stp_las_numbers_of_format(stp_las_numbers *out, const stp_las_format *format, bool coloured,
                               bool withheld)
{
    static const char *const colours[3] = {"red", "green", "blue"};
    const known_field *known = format->extended ? extended_fields : legacy_fields;
    const size_t count = format->extended ? sizeof extended_fields / sizeof *extended_fields
                                          : sizeof legacy_fields / sizeof *legacy_fields;
    *out = (stp_las_numbers){0};
    for (size_t i = 0; i < count; i++)
        stp_las_numbers_add(out, known[i].name, known[i].type, known[i].field, known[i].scale);
    if (withheld)
        stp_las_numbers_add(out, "withheld", STP_ATTRIBUTE_U8,
                            (stp_las_field){15, format->extended ? 2 : 7, 1}, 1.0);
    if (format->gps_time > 0)
        stp_las_numbers_add(out, "gps_time", STP_ATTRIBUTE_F64,
                            (stp_las_field){format->gps_time, 0, 0}, 1.0);
    for (int k = 0; k < 3 && coloured && format->rgb > 0; k++)
        stp_las_numbers_add(out, colours[k], STP_ATTRIBUTE_U16,
                            (stp_las_field){(uint16_t)(format->rgb + 2 * k), 0, 0}, 1.0);
    if (format->nir > 0)
        stp_las_numbers_add(out, "nir", STP_ATTRIBUTE_U16, (stp_las_field){format->nir, 0, 0}, 1.0);
}

/* A name of printable ASCII without spaces at its end. */
static void extra_name(const unsigned char *record, char out[EXTRA_NAME_BYTES + 1])
{
    size_t length = 0;
    while (length < EXTRA_NAME_BYTES && record[AT_EXTRA_NAME + length] != 0)
        length++;
    while (length > 0 && isspace(record[AT_EXTRA_NAME + length - 1]))
        length--;
    for (size_t i = 0; i < length; i++) {
        const unsigned char c = record[AT_EXTRA_NAME + i];
        out[i] = (char)(c >= 32 && c < 127 ? c : '?');
    }
    out[length] = '\0';
}

/* Scale and offset of a described attribute; 1 and 0 if they are not given or make no sense. */
static void extra_scale(const unsigned char *record, stp_attribute *a)
{
    const double scale = stp_las_double(record + AT_EXTRA_SCALE);
    const double offset = stp_las_double(record + AT_EXTRA_OFFSET);
    if (record[AT_EXTRA_OPTIONS] & OPTION_SCALE && isfinite(scale) && scale != 0.0)
        a->scale = scale;
    if (record[AT_EXTRA_OPTIONS] & OPTION_OFFSET && isfinite(offset))
        a->offset = offset;
}

/* Adds bytes [at, end) of the record one by one. */
static void add_bytes(stp_las_numbers *out, uint32_t first, uint32_t at, uint32_t end)
{
    char name[24];
    for (; at < end; at++) {
        snprintf(name, sizeof name, "extra_%u", at - first);
        stp_las_numbers_add(out, name, STP_ATTRIBUTE_U8, (stp_las_field){(uint16_t)at, 0, 0}, 1.0);
    }
}

static void add_extra(stp_las_numbers *out, const stp_las_header *header,
                      const stp_las_record *described)
{
    static const stp_attribute_type types[] = {
        STP_ATTRIBUTE_TYPE_COUNT, STP_ATTRIBUTE_U8,  STP_ATTRIBUTE_I8,  STP_ATTRIBUTE_U16,
        STP_ATTRIBUTE_I16,        STP_ATTRIBUTE_U32, STP_ATTRIBUTE_I32, STP_ATTRIBUTE_U64,
        STP_ATTRIBUTE_I64,        STP_ATTRIBUTE_F32, STP_ATTRIBUTE_F64};
    const uint32_t first = header->format->bytes, end = header->record_bytes;
    uint32_t at = first;
    for (size_t r = 0; r + EXTRA_BYTES <= described->length && at < end; r += EXTRA_BYTES) {
        const unsigned char *record = described->bytes + r;
        const unsigned kind = record[AT_EXTRA_TYPE];
        char name[EXTRA_NAME_BYTES + 1];
        if (kind == 0 || kind >= sizeof types / sizeof *types)
            break; /* bytes without a type, or arrays: the rest one by one */
        const uint32_t bytes = (uint32_t)stp_attribute_bytes(types[kind]);
        if (bytes > end - at)
            break;
        extra_name(record, name);
        stp_attribute *a = name[0] ? stp_las_numbers_add(out, name, types[kind],
                                                         (stp_las_field){(uint16_t)at, 0, 0}, 1.0)
                                   : NULL;
        if (a)
            extra_scale(record, a);
        else
            add_bytes(out, first, at, at + bytes);
        at += bytes;
    }
    add_bytes(out, first, at, end);
}

void stp_las_numbers_relate(stp_las_numbers *out, const stp_las_depth *depth)
{
    static const char *const names[] = {"red", "green", "blue", "intensity"};
    static const double scales[] = {[STP_LAS_COLOUR_8] = 1.0,
                                    [STP_LAS_COLOUR_8_TIMES_256] = 256.0,
                                    [STP_LAS_COLOUR_10] = 1023.0 / 255.0,
                                    [STP_LAS_COLOUR_12] = 4095.0 / 255.0,
                                    [STP_LAS_COLOUR_16] = 257.0};
    for (unsigned k = 0; k < 4; k++) {
        const uint32_t found = stp_attribute_find(&out->list, names[k]);
        const bool colour = k < 3;
        if (found == UINT32_MAX || out->list.items[found].type != STP_ATTRIBUTE_U16 ||
            (colour && depth->colour == STP_LAS_COLOUR_NONE))
            continue;
        stp_attribute *a = &out->list.items[found];
        a->coarse = (stp_attribute_coarse)(STP_COARSE_RED + k);
        a->coarse_scale = colour               ? scales[depth->colour]
                          : depth->intensity_8 ? 1.0 / 257.0
                                               : 1.0; /* prep knows the greatest */
    }
}

void stp_las_numbers_of_file(stp_las_numbers *out, const stp_las_header *header,
                             const stp_las_records *records, const stp_las_depth *depth,
                             bool withheld)
{
    const bool coloured = depth->colour != STP_LAS_COLOUR_NONE;
    stp_las_numbers_of_format(out, header->format, coloured, withheld);
    stp_las_numbers_relate(out, depth);
    add_extra(out, header, &records->kept[STP_LAS_EXTRA_BYTES]);
}

void stp_las_numbers_pack(const stp_las_numbers *numbers, const unsigned char *records,
                          size_t stride, size_t count, uint8_t *out)
{
    const size_t bytes = stp_attribute_list_bytes(&numbers->list);
    for (uint32_t a = 0; a < numbers->list.count; a++) {
        const stp_las_field field = numbers->fields[a];
        const size_t size = stp_attribute_bytes(numbers->list.items[a].type);
        const uint8_t mask = (uint8_t)((1u << field.bits) - 1u);
        for (size_t i = 0; i < count; i++) {
            const unsigned char *from = records + i * stride + field.at;
            if (field.bits > 0)
                out[i * bytes] = *from >> field.shift & mask;
            else
                memcpy(out + i * bytes, from, size);
        }
        out += size;
    }
}

void stp_las_field_put(const stp_las_field *field, stp_attribute_type type, uint64_t word,
                       unsigned char *record)
{
    unsigned char *to = record + field->at;
    if (field->bits == 0) {
        stp_attribute_put(type, word, to);
        return;
    }
    const unsigned mask = ((1u << field->bits) - 1u) << field->shift;
    *to = (unsigned char)((*to & ~mask) | ((unsigned)word << field->shift & mask));
}
