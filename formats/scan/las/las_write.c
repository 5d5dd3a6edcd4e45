/* Writes points as a stream of LAS 1.4, or of LAZ. */
#include "formats/scan/las/las_write.h"

#include "base/file.h"
#include "base/memory.h"
#include "formats/scan/las/las_bytes.h"
#include "formats/scan/las/las_header.h"
#include "formats/scan/las/las_numbers.h"
#include "formats/scan/las/laz/laz_pack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Bytes are collected in blocks, so that stp_output is called once per block, not per point. */
#define STP_LAS_BLOCK_RECORDS 1024u
/* Says that a coordinate system is WKT. The standard requires that for formats 6 and up, even if
 * there is no coordinate system. */
#define ENCODING_WKT 0x10u
/* Header of a variable length record, and a description of extra bytes in one. */
#define VLR_BYTES 54u
#define EXTRA_BYTES 192u
#define VLR_CONTENT_MOST 65535u
#define RETURNS 15u
/* Added to the byte of the point format if points are packed. */
#define PACKED 0x80u

struct stp_las_writer {
    stp_output *output;
    char *path, *wkt;
    stp_las_writer_params params;
    const stp_las_format *format;
    unsigned point_format;
    uint64_t written;
    uint64_t by_return[RETURNS];
    int32_t min[3], max[3]; /* in steps; min > max: no points */
    double steps[3];
    stp_las_field fields[STP_ATTRIBUTES_LIMIT]; /* of params.numbers */
    bool extra[STP_ATTRIBUTES_LIMIT];           /* it lies in extra bytes */
    uint32_t record_bytes, extra_count;
    unsigned char *block;
    stp_laz_packer *packer;                     /* NULL: not packed */
    unsigned char packing[STP_LAZ_RECORD_MOST]; /* "laszip encoded" */
    size_t packing_bytes;                       /* 0: not packed */
};

double stp_las_finest_step(double reach)
{
    /* Powers of ten up to 10^22 are exact doubles, so 1 divided by one of them is rounded only
     * once. */
    int exponent = (int)ceil(log10(reach / INT32_MAX));
    for (;; exponent++) {
        const double step = exponent < 0 ? 1.0 / pow(10.0, -exponent) : pow(10.0, exponent);
        if (reach / step < (double)INT32_MAX)
            return step;
    }
}

/* Bytes of the records between header and points. */
static uint64_t records_bytes(const stp_las_writer *w)
{
    uint64_t bytes = w->extra_count > 0 ? VLR_BYTES + (uint64_t)w->extra_count * EXTRA_BYTES : 0;
    if (w->params.wkt)
        bytes += VLR_BYTES + strlen(w->params.wkt) + 1;
    if (w->packing_bytes > 0)
        bytes += VLR_BYTES + w->packing_bytes;
    return bytes;
}

static void put_header(const stp_las_writer *w, unsigned char *h)
{
    static const char signature[4] = {'L', 'A', 'S', 'F'};
    static const char system_identifier[32] = "OTHER", generating_software[32] = "stipple";
    const double offset[3] = {w->params.offset.x, w->params.offset.y, w->params.offset.z};
    const uint64_t points_begin = STP_LAS_HEADER_BYTES_1_4 + records_bytes(w);
    const bool extended = w->format->extended;
    memset(h, 0, STP_LAS_HEADER_BYTES_1_4);
    memcpy(h, signature, sizeof signature);
    stp_las_put_u16(h + 6, extended || w->params.wkt ? ENCODING_WKT : 0);
    h[24] = 1;
    h[25] = 4;
    memcpy(h + 26, system_identifier, sizeof system_identifier);
    memcpy(h + 58, generating_software, sizeof generating_software);
    stp_las_put_u16(h + 94, STP_LAS_HEADER_BYTES_1_4);
    stp_las_put_u32(h + 96, (uint32_t)points_begin);
    stp_las_put_u32(h + 100, (w->extra_count > 0 ? 1u : 0u) + (w->params.wkt ? 1u : 0u) +
                                 (w->packing_bytes > 0 ? 1u : 0u));
    h[104] = (unsigned char)(w->point_format | (w->packing_bytes > 0 ? PACKED : 0));
    stp_las_put_u16(h + 105, (uint16_t)w->record_bytes);
    for (int axis = 0; axis < 3; axis++) {
        stp_las_put_double(h + 131 + 8 * axis, w->steps[axis]);
        stp_las_put_double(h + 155 + 8 * axis, offset[axis]);
        if (w->written == 0)
            continue;
        stp_las_put_double(h + 179 + 16 * axis, w->max[axis] * w->steps[axis] + offset[axis]);
        stp_las_put_double(h + 187 + 16 * axis, w->min[axis] * w->steps[axis] + offset[axis]);
    }
    stp_las_put_u64(h + 247, w->written); /* the 32-bit counts are 0 for formats 6 and up */
    for (unsigned r = 0; r < RETURNS; r++)
        stp_las_put_u64(h + 255 + (size_t)8 * r, w->by_return[r]);
    if (!extended && w->written <= UINT32_MAX) {
        stp_las_put_u32(h + 107, (uint32_t)w->written);
        for (unsigned r = 0; r < 5; r++)
            stp_las_put_u32(h + 111 + (size_t)4 * r, (uint32_t)w->by_return[r]);
    }
}

/* ---- attributes ---- */

static bool has_number(const stp_las_writer_params *params, const char *name)
{
    return params->numbers && stp_attribute_find(params->numbers, name) != UINT32_MAX;
}

static unsigned choose_format(const stp_las_writer_params *params)
{
    const bool colour = params->attributes & STP_POINT_HAS_COLOUR || has_number(params, "red");
    if (has_number(params, "scan_angle_rank"))
        return (has_number(params, "gps_time") ? 1u : 0u) + (colour ? 2u : 0u);
    return has_number(params, "nir") ? 8 : colour ? 7 : 6;
}

/* Finds the attributes' fields in the format. The others become extra bytes behind it. */
static void place_numbers(stp_las_writer *w)
{
    const stp_attribute_list *list = w->params.numbers;
    stp_las_numbers known;
    stp_las_numbers_of_format(&known, w->format, true, true);
    w->record_bytes = w->format->bytes;
    for (uint32_t a = 0; list && a < list->count; a++) {
        const stp_attribute *attribute = &list->items[a];
        const uint32_t k = stp_attribute_find(&known.list, attribute->name);
        w->extra[a] = k == UINT32_MAX || known.list.items[k].type != attribute->type ||
                      known.list.items[k].scale != attribute->scale;
        if (!w->extra[a]) {
            w->fields[a] = known.fields[k];
            continue;
        }
        w->fields[a] = (stp_las_field){(uint16_t)w->record_bytes, 0, 0};
        w->record_bytes += (uint32_t)stp_attribute_bytes(attribute->type);
        w->extra_count++;
    }
}

static void put_vlr(unsigned char *at, const char *user, uint16_t id, size_t content)
{
    memset(at, 0, VLR_BYTES);
    for (size_t i = 0; user[i] != '\0'; i++) /* at most 16 */
        at[2 + i] = (unsigned char)user[i];
    stp_las_put_u16(at + 18, id);
    stp_las_put_u16(at + 20, (uint16_t)content);
}

/* Describes an attribute in extra bytes. */
static void put_extra(const stp_attribute *a, unsigned char *at)
{
    static const unsigned char types[STP_ATTRIBUTE_TYPE_COUNT] = {
        [STP_ATTRIBUTE_U8] = 1,  [STP_ATTRIBUTE_I8] = 2,  [STP_ATTRIBUTE_U16] = 3,
        [STP_ATTRIBUTE_I16] = 4, [STP_ATTRIBUTE_U32] = 5, [STP_ATTRIBUTE_I32] = 6,
        [STP_ATTRIBUTE_U64] = 7, [STP_ATTRIBUTE_I64] = 8, [STP_ATTRIBUTE_F32] = 9,
        [STP_ATTRIBUTE_F64] = 10};
    memset(at, 0, EXTRA_BYTES);
    at[2] = types[a->type];
    strncpy((char *)at + 4, a->name, 32);
    if (a->has_missing && !stp_attribute_is_float(a->type)) {
        at[3] |= 1;
        stp_las_put_u64(at + 40, (uint64_t)a->missing);
    }
    if (a->scale != 1.0 || a->offset != 0.0) {
        at[3] |= 8 | 16;
        stp_las_put_double(at + 112, a->scale);
        stp_las_put_double(at + 136, a->offset);
    }
}

/* Writes the records between header and points. */
static stp_status write_records(stp_las_writer *w, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_attribute_list *list = w->params.numbers;
    unsigned char head[VLR_BYTES], extra[EXTRA_BYTES];
    if (w->params.wkt) {
        const size_t size = strlen(w->params.wkt) + 1;
        put_vlr(head, "LASF_Projection", 2112, size);
        STP_TRY(stp_output_write(w->output, head, sizeof head, err));
        STP_TRY(stp_output_write(w->output, w->params.wkt, size, err));
    }
    if (w->extra_count > 0) {
        put_vlr(head, "LASF_Spec", 4, (size_t)w->extra_count * EXTRA_BYTES);
        STP_TRY(stp_output_write(w->output, head, sizeof head, err));
    }
    for (uint32_t a = 0; list && a < list->count; a++)
        if (w->extra[a]) {
            put_extra(&list->items[a], extra);
            STP_TRY(stp_output_write(w->output, extra, sizeof extra, err));
        }
    if (w->packing_bytes > 0) {
        put_vlr(head, "laszip encoded", 22204, w->packing_bytes);
        STP_TRY(stp_output_write(w->output, head, sizeof head, err));
        STP_TRY(stp_output_write(w->output, w->packing, w->packing_bytes, err));
    }
done:
    return status;
}

stp_status stp_las_writer_create(stp_las_writer **out, const char *path,
                                 const stp_las_writer_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_las_writer *w = NULL;
    unsigned char header[STP_LAS_HEADER_BYTES_1_4];
    stp_laz_layout layout;
    if (params->attributes & STP_POINT_HAS_NORMAL)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: LAS has no normals: write PLY, or no normals", path);
    if (!(params->step > 0.0) || !isfinite(params->step) || !stp_dvec3_finite(params->offset))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: a LAS file needs a positive step and a finite offset, not %g and "
                             "(%g, %g, %g)",
                             path, params->step, params->offset.x, params->offset.y,
                             params->offset.z);
    STP_TRY(stp_alloc(&w, 1, sizeof *w, "LAS writer", err));
    w->params = *params;
    w->params.wkt = NULL;
    if (params->wkt && strlen(params->wkt) < VLR_CONTENT_MOST) { /* no record holds a longer one */
        STP_TRY(stp_text_copy(&w->wkt, params->wkt, "a coordinate system", err));
        w->params.wkt = w->wkt;
    }
    w->point_format = choose_format(params);
    w->format = stp_las_format_get(w->point_format);
    place_numbers(w);
    if (params->packed) {
        STP_TRY(stp_laz_layout_make(&layout, w->format, w->record_bytes, STP_LAZ_CHUNK_POINTS, path,
                                    err));
        w->packing_bytes = stp_laz_layout_put(&layout, w->packing);
    }
    STP_TRY(stp_alloc(&w->block, STP_LAS_BLOCK_RECORDS, w->record_bytes, "LAS writer", err));
    for (int axis = 0; axis < 3; axis++) {
        w->steps[axis] = params->steps[axis] > 0.0 ? params->steps[axis] : params->step;
        w->min[axis] = INT32_MAX;
        w->max[axis] = INT32_MIN;
    }
    STP_TRY(stp_text_copy(&w->path, path, "path", err));
    STP_TRY(stp_output_create(&w->output, path, params->force, err));
    put_header(w, header);
    STP_TRY(stp_output_write(w->output, header, sizeof header, err));
    STP_TRY(write_records(w, err));
    if (params->packed)
        STP_TRY(stp_laz_packer_create(&w->packer, &layout, w->output, err));
    *out = w;
    w = NULL;
done:
    stp_las_writer_destroy(&w);
    return status;
}

static stp_status put_position(stp_las_writer *w, unsigned char *record, const stp_point *point,
                               stp_error *err)
{
    const double at[3] = {point->position.x, point->position.y, point->position.z};
    const double offset[3] = {w->params.offset.x, w->params.offset.y, w->params.offset.z};
    for (int axis = 0; axis < 3; axis++) {
        const double steps = nearbyint((at[axis] - offset[axis]) / w->steps[axis]);
        if (!(steps >= INT32_MIN && steps <= INT32_MAX))
            return stp_error_set(err, STP_INVALID_ARGUMENT,
                                 "%s: %c = %.17g does not fit LAS integers of step %g from %.17g: "
                                 "take a coarser step or another offset",
                                 w->path, "xyz"[axis], at[axis], w -> steps[axis], offset[axis]);
        const int32_t value = (int32_t)steps;
        w->min[axis] = value < w->min[axis] ? value : w->min[axis];
        w->max[axis] = value > w->max[axis] ? value : w->max[axis];
        stp_las_put_u32(record + 4 * axis, (uint32_t)value);
    }
    return STP_OK;
}

/* packed: the point's attributes; NULL for none. */
static stp_status put_point(stp_las_writer *w, unsigned char *record, const stp_point *point,
                            const uint8_t *packed, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t has = w->params.attributes;
    const bool extended = w->format->extended;
    memset(record, 0, w->record_bytes);
    STP_TRY(put_position(w, record, point, err));
    if (has & STP_POINT_HAS_INTENSITY)
        stp_las_put_u16(record + 12, point->intensity);
    record[14] = extended ? 0x11 : 0x09; /* return 1 of 1 */
    if (has & STP_POINT_HAS_CLASS)
        record[extended ? 16 : 15] = extended ? point->class_id : point->class_id & 0x1f;
    if (has & STP_POINT_HAS_STATION)
        stp_las_put_u16(record + (extended ? 20 : 18), point->station);
    for (unsigned k = 0; k < 3 && (has & STP_POINT_HAS_COLOUR); k++)
        stp_las_put_u16(record + w->format->rgb + 2 * k, point->rgb[k]);
    for (uint32_t a = 0; packed && a < w->params.numbers->count; a++) {
        const stp_attribute_type type = w->params.numbers->items[a].type;
        stp_las_field_put(&w->fields[a], type, stp_attribute_get(type, packed), record);
        packed += stp_attribute_bytes(type);
    }
    const unsigned number = record[14] & (extended ? 15u : 7u);
    w->by_return[number >= 1 ? number - 1 : 0] += number >= 1 && number <= RETURNS;
done:
    return status;
}

stp_status stp_las_writer_points(stp_las_writer *writer, const stp_point *points, size_t count,
                                 stp_error *err)
{
    return stp_las_writer_numbered_points(writer, points, NULL, count, err);
}

stp_status stp_las_writer_numbered_points(stp_las_writer *writer, const stp_point *points,
                                          const uint8_t *packed, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t bytes = writer->record_bytes;
    const size_t stride = packed ? stp_attribute_list_bytes(writer->params.numbers) : 0;
    while (count > 0) {
        const size_t part = count < STP_LAS_BLOCK_RECORDS ? count : STP_LAS_BLOCK_RECORDS;
        for (size_t i = 0; i < part; i++)
            STP_TRY(put_point(writer, writer->block + i * bytes, &points[i],
                              packed ? packed + i * stride : NULL, err));
        status = writer->packer
                     ? stp_laz_packer_records(writer->packer, writer->block, part, err)
                     : stp_output_write(writer->output, writer->block, part * bytes, err);
        if (status != STP_OK)
            goto done;
        writer->written += part;
        points += part;
        packed = packed ? packed + part * stride : NULL;
        count -= part;
    }
done:
    return status;
}

stp_status stp_las_writer_finish(stp_las_writer **writer, stp_error *err)
{
    stp_status status = STP_OK;
    stp_las_writer *w = *writer;
    unsigned char header[STP_LAS_HEADER_BYTES_1_4];
    if (w->packer)
        STP_TRY(stp_laz_packer_finish(w->packer, err));
    put_header(w, header);
    STP_TRY(stp_output_write_at(w->output, 0, header, sizeof header, err));
    STP_TRY(stp_output_commit(&w->output, err));
done:
    stp_las_writer_destroy(writer);
    return status;
}

void stp_las_writer_destroy(stp_las_writer **writer)
{
    stp_las_writer *w = *writer;
    if (!w)
        return;
    stp_laz_packer_destroy(&w->packer);
    stp_output_destroy(&w->output);
    free(w->block);
    free(w->wkt);
    free(w->path);
    free(w);
    *writer = NULL;
}
