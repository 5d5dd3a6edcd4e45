/* Reads PCD files as a stream of points. */
#include "formats/scan/pcd/pcd.h"

#include "base/memory.h"
#include "formats/scan/mesh/point_mesh.h"
#include "formats/scan/name_list.h"
#include "formats/scan/pcd/pcd_values.h"
#include "formats/scan/value_range.h"

#include <stdlib.h>

typedef struct reader {
    stp_pcd_values values;
    uint32_t attributes; /* STP_POINT_HAS_* */
    bool packed_colour;
    bool zeros;                           /* (0, 0, 0) is a hole of the image */
    double colour_scale, intensity_scale; /* file value to 0..65535 */
    double intensity_low;                 /* file value that means 0 */
    stp_name_list left_out;
    stp_scan_note note;
} reader;

static void find_attributes(reader *r)
{
    const stp_pcd_header *h = &r->values.header;
    r->packed_colour = stp_pcd_header_find(h, STP_PCD_PACKED) != NULL;
    if (r->packed_colour || stp_pcd_header_find(h, STP_PCD_RED))
        r->attributes |= STP_POINT_HAS_COLOUR;
    if (stp_pcd_header_find(h, STP_PCD_NX))
        r->attributes |= STP_POINT_HAS_NORMAL;
    if (stp_pcd_header_find(h, STP_PCD_INTENSITY))
        r->attributes |= STP_POINT_HAS_INTENSITY;
    if (stp_pcd_header_find(h, STP_PCD_CLASS))
        r->attributes |= STP_POINT_HAS_CLASS;
    if (h->has_viewpoint && stp_dvec3_finite(h->viewpoint))
        r->attributes |= STP_POINT_HAS_STATION;
}

static stp_status find_intensity_scale(reader *r, stp_error *err)
{
    const stp_pcd_field *field = stp_pcd_header_find(&r->values.header, STP_PCD_INTENSITY);
    stp_value_span span = {0};
    stp_status status = STP_OK;
    if (!field)
        return STP_OK;
    if (field->size > 1 || field->type != 'U')
        STP_TRY(stp_pcd_values_span(&r->values, STP_PCD_INTENSITY, STP_PCD_INTENSITY, &span, err));
    const stp_value_range range =
        stp_value_range_guess_intensity(field->type == 'F', field->size, span);
    r->intensity_low = range.low;
    r->intensity_scale = stp_value_range_scale(range);
done:
    return status;
}

/* Colours that are all zero are none: a program wrote them for want of any. */
static stp_status find_colour_scale(reader *r, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_pcd_target first = r->packed_colour ? STP_PCD_PACKED : STP_PCD_RED;
    const stp_pcd_field *field = stp_pcd_header_find(&r->values.header, first);
    stp_value_span span = {0};
    if (!field)
        return STP_OK;
    STP_TRY(stp_pcd_values_span(&r->values, first, r->packed_colour ? STP_PCD_PACKED : STP_PCD_BLUE,
                                &span, err));
    if (span.max <= 0.0)
        r->attributes &= ~(uint32_t)STP_POINT_HAS_COLOUR;
    r->colour_scale = stp_value_range_scale(
        stp_value_range_guess_colour(field->type == 'F', field->size, span.max));
done:
    return status;
}

static void list_left_out(reader *r)
{
    const stp_pcd_header *h = &r->values.header;
    for (size_t i = 0; i < h->field_count; i++)
        if (h->fields[i].target == STP_PCD_TARGET_COUNT &&
            !stp_pcd_field_is_padding(&h->fields[i]) &&
            !(h->fields[i].extra > 0 && r->values.keeps_numbers))
            stp_name_list_add(&r->left_out, h->fields[i].name);
    r->note = (stp_scan_note){"left_out", r->left_out.text};
}

/* Returns 1 if all coordinates are whole numbers. */
static double coordinate_step(const stp_pcd_header *h)
{
    for (int axis = 0; axis < 3; axis++)
        if (stp_pcd_header_find(h, (stp_pcd_target)axis)->type == 'F')
            return 0.0;
    return 1.0;
}

static void fill_info(const reader *r, stp_scan_info *info)
{
    static const char *const names[] = {
        [STP_PCD_ASCII] = "PCD ascii",
        [STP_PCD_BINARY] = "PCD binary",
        [STP_PCD_COMPRESSED] = "PCD binary_compressed",
    };
    const stp_pcd_header *h = &r->values.header;
    info->format = names[h->encoding];
    info->point_count = h->points;
    info->seek_points = h->encoding == STP_PCD_BINARY && h->points > 0;
    info->lost_count = r->values.lost_count;
    info->attributes = r->attributes;
    info->coordinate_step = coordinate_step(h);
    if (r->intensity_scale > 0.0 && r->intensity_low == 0.0)
        info->intensity_full = 65535.0 / r->intensity_scale;
    if (stp_dvec3_finite(h->viewpoint)) {
        info->stations = &h->viewpoint;
        info->station_count = 1;
        info->station_word = h->has_viewpoint ? STP_STATION_CLAIMED : STP_STATION_DEFAULT;
    }
    if (h->height > 1 && h->height <= UINT32_MAX && h->points / h->height <= UINT32_MAX)
        info->grid = (stp_scan_grid){.columns = (uint32_t)(h->points / h->height),
                                     .rows = (uint32_t)h->height};
    info->extra = r->values.numbers.list.count > 0 ? &r->values.numbers.list : NULL;
    info->notes = &r->note;
    info->note_count = r->left_out.text[0] ? 1 : 0;
}

static void set_colours(const reader *r, stp_point *points, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        for (int c = 0; c < 3; c++) {
            const uint32_t byte = r->values.packed[i] >> (16 - 8 * c) & 255u;
            points[i].rgb[c] = r->packed_colour
                                   ? (uint16_t)(257u * byte)
                                   : stp_value_range_map(r->values.columns[STP_PCD_RED + c][i], 0.0,
                                                         r->colour_scale);
        }
    }
}

static void set_scalars(const reader *r, stp_point *points, size_t count)
{
    const double(*c)[STP_PCD_BLOCK_POINTS] = r->values.columns;
    if (r->attributes & STP_POINT_HAS_INTENSITY)
        for (size_t i = 0; i < count; i++)
            points[i].intensity =
                stp_value_range_map(c[STP_PCD_INTENSITY][i], r->intensity_low, r->intensity_scale);
    if (r->attributes & STP_POINT_HAS_CLASS)
        for (size_t i = 0; i < count; i++)
            points[i].class_id = stp_class_of(c[STP_PCD_CLASS][i]);
}

static void columns_to_points(const reader *r, stp_point *points, size_t count)
{
    const double(*c)[STP_PCD_BLOCK_POINTS] = r->values.columns;
    const stp_pcd_header *h = &r->values.header;
    for (size_t i = 0; i < count; i++)
        points[i] = (stp_point){.position = {c[STP_PCD_X][i], c[STP_PCD_Y][i], c[STP_PCD_Z][i]},
                                .station = stp_dvec3_finite(h->viewpoint)};
    for (size_t i = 0; h->height > 1 && i < count; i++)
        if (!stp_dvec3_finite(points[i].position))
            points[i].reject = STP_REJECT_NO_RETURN;
        else if (r->zeros && stp_dvec3_equal(points[i].position, (stp_dvec3){0.0, 0.0, 0.0}))
            points[i].reject = STP_REJECT_ORIGIN;
    if (r->attributes & STP_POINT_HAS_NORMAL)
        for (size_t i = 0; i < count; i++)
            points[i].normal =
                stp_unit_normal((stp_dvec3){c[STP_PCD_NX][i], c[STP_PCD_NY][i], c[STP_PCD_NZ][i]});
    if (r->attributes & STP_POINT_HAS_COLOUR)
        set_colours(r, points, count);
    set_scalars(r, points, count);
}

static stp_status read_points(void *state, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    reader *r = state;
    stp_pcd_values *v = &r->values;
    size_t got = 0;
    if (v->keeps_numbers)
        STP_TRY(stp_pcd_numbers_reserve(&v->numbers, capacity, err));
    while (got < capacity && v->index < v->header.points) {
        size_t part = capacity - got;
        const uint64_t left = v->header.points - v->index;
        part = part < v->block_points ? part : v->block_points;
        part = part < left ? part : (size_t)left;
        STP_TRY(stp_pcd_values_read(
            v, part, v->numbers.packed ? v->numbers.packed + got * v->numbers.stride : NULL, err));
        columns_to_points(r, points + got, part);
        got += part;
    }
    *count = got;
done:
    return status;
}

static void close_reader(void *state)
{
    reader *r = state;
    stp_pcd_values_close(&r->values);
}

static stp_status open_reader(void *state, stp_scan_info *info, const char *path,
                              const stp_scan_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    reader *r = state;
    r->values.source.descriptor = -1;
    r->values.keeps_numbers = params->numbers;
    r->values.salvage = params->salvage;
    STP_TRY(stp_pcd_values_open(&r->values, path, err));
    find_attributes(r);
    STP_TRY(stp_pcd_values_find_packing(&r->values, err));
    STP_TRY(find_colour_scale(r, err));
    STP_TRY(find_intensity_scale(r, err));
    if (r->values.header.height > 1)
        STP_TRY(stp_pcd_values_find_zeros(&r->values, &r->zeros, err));
    list_left_out(r);
    fill_info(r, info);
done:
    return status;
}

static stp_status seek_record(void *state, uint64_t point, stp_error *err)
{
    (void)err;
    stp_pcd_values_seek(&((reader *)state)->values, point);
    return STP_OK;
}

static const uint8_t *packed_numbers(const void *state)
{
    return ((const reader *)state)->values.numbers.packed;
}

const stp_scan_reader stp_pcd_reader = {sizeof(reader), open_reader, read_points,
                                        close_reader,   seek_record, packed_numbers};
