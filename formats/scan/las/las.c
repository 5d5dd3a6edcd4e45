/* Reads LAS and LAZ files as a stream of points. */
#include "formats/scan/las/las.h"

#include "base/memory.h"
#include "formats/scan/las/las_bytes.h"
#include "formats/scan/las/las_depth.h"
#include "formats/scan/las/las_notes.h"
#include "formats/scan/las/las_numbers.h"
#include "formats/scan/las/laz.h"
#include "formats/scan/value_range.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Holds a block of records for most files. Longer records come in smaller blocks. */
#define STP_LAS_BLOCK_BYTES ((size_t)1 << 16)
#define STP_LAS_BLOCK_POINTS 1024u

/* Offsets of fields in a record, the same in all formats. */
enum { AT_INTENSITY = 12, AT_CLASS_AND_FLAGS = 15, AT_EXTENDED_CLASS = 16 };

typedef struct las_reader {
    stp_source source;
    stp_las_header header;
    stp_las_records records;
    stp_las_depth depth;
    stp_las_notes notes;
    stp_laz *laz;            /* NULL: not compressed */
    unsigned char *unpacked; /* records that laz unpacked */
    size_t block_points;
    uint64_t next; /* point */
    stp_las_numbers numbers;
    bool keeps_numbers;
    uint8_t *packed; /* numbers of the points read last */
    size_t packed_capacity;
    char format[40];
} las_reader;

static stp_status seek_point(las_reader *las, uint64_t point, stp_error *err)
{
    las->next = point;
    if (las->laz)
        return stp_laz_seek(las->laz, point, err);
    /* No overflow: the header was checked against the file's size. */
    stp_source_seek(&las->source, las->header.point_offset + point * las->header.record_bytes, 0);
    return STP_OK;
}

/* Gets the next count <= block_points records, valid until the next call. */
static stp_status next_records(las_reader *las, size_t count, const unsigned char **records,
                               stp_error *err)
{
    stp_status status = STP_OK;
    const size_t bytes = count * las->header.record_bytes;
    if (las->laz) {
        STP_TRY(stp_laz_read(las->laz, las->unpacked, count, err));
        *records = las->unpacked;
    } else {
        size_t available;
        STP_TRY(stp_source_peek(&las->source, bytes, records, &available, err));
        assert(available == bytes); /* the file had them when it was opened; fewer are an error */
        stp_source_consume(&las->source, bytes);
    }
    las->next += count;
done:
    return status;
}

/* Finds the depths as in las_depth.h and goes back to the first point. */
static stp_status find_depth(las_reader *las, stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned blocks = las->laz ? STP_LAS_SAMPLE_BLOCKS_COMPRESSED : STP_LAS_SAMPLE_BLOCKS;
    const uint64_t total = las->header.point_count;
    stp_las_seen seen = {0};
    for (unsigned block = 0; block < blocks; block++) {
        uint64_t first = stp_spread_begin(total, block, blocks);
        first =
            first > las->next ? first : las->next; /* else blocks of small files would overlap */
        uint64_t end =
            total - first < STP_LAS_SAMPLE_POINTS ? total : first + STP_LAS_SAMPLE_POINTS;
        if (first == end)
            break;
        STP_TRY(seek_point(las, first, err));
        while (las->next < end) {
            const uint64_t left = end - las->next;
            const size_t part = left < las->block_points ? (size_t)left : las->block_points;
            const unsigned char *records;
            STP_TRY(next_records(las, part, &records, err));
            stp_las_depth_look(&seen, &las->header, records, part);
        }
    }
    las->depth = stp_las_depth_decide(&seen);
    STP_TRY(seek_point(las, 0, err));
done:
    return status;
}

static void decode_colours(const las_reader *las, const unsigned char *record, stp_point *points,
                           size_t count)
{
    const size_t stride = las->header.record_bytes;
    const stp_las_colour_depth depth = las->depth.colour;
    record += las->header.format->rgb;
    for (size_t i = 0; i < count; i++, record += stride)
        for (int k = 0; k < 3; k++) {
            const uint16_t value = stp_las_u16(record + 2 * k);
            points[i].rgb[k] = depth == STP_LAS_COLOUR_16  ? value
                               : depth == STP_LAS_COLOUR_8 ? stp_las_widen(value)
                                                           : stp_las_widen(value >> 8);
        }
}

static bool is_withheld(const unsigned char *record, bool extended)
{
    return record[AT_CLASS_AND_FLAGS] & (extended ? 0x04 : 0x80);
}

static void decode(const las_reader *las, const unsigned char *record, stp_point *points,
                   size_t count)
{
    const size_t stride = las->header.record_bytes;
    const bool extended = las->header.format->extended, narrow = las->depth.intensity_8;
    const double *scale = las->header.scale, *offset = las->header.offset;
    const unsigned char *at = record;
    for (size_t i = 0; i < count; i++, at += stride) {
        const uint16_t intensity = stp_las_u16(at + AT_INTENSITY);
        points[i] = (stp_point){
            .position = {(int32_t)stp_las_u32(at) * scale[0] + offset[0],
                         (int32_t)stp_las_u32(at + 4) * scale[1] + offset[1],
                         (int32_t)stp_las_u32(at + 8) * scale[2] + offset[2]},
            .intensity = narrow ? stp_las_widen(intensity) : intensity,
            .class_id = extended ? at[AT_EXTENDED_CLASS] : at[AT_CLASS_AND_FLAGS] & 0x1f,
            .reject = is_withheld(at, extended) ? STP_REJECT_INVALID : STP_REJECT_NONE};
    }
    if (las->header.format->rgb > 0 && las->depth.colour != STP_LAS_COLOUR_NONE)
        decode_colours(las, record, points, count);
}

static stp_status read_points(void *state, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    las_reader *las = state;
    size_t done_count = 0;
    const size_t stride = stp_attribute_list_bytes(&las->numbers.list);
    if (las->keeps_numbers)
        STP_TRY(
            stp_grow(&las->packed, &las->packed_capacity, capacity * stride, 1, "attributes", err));
    while (done_count < capacity && las->next < las->header.point_count) {
        const uint64_t left = las->header.point_count - las->next;
        size_t part = capacity - done_count;
        const unsigned char *records;
        part = part < las->block_points ? part : las->block_points;
        part = part < left ? part : (size_t)left;
        STP_TRY(next_records(las, part, &records, err));
        decode(las, records, points + done_count, part);
        if (las->keeps_numbers)
            stp_las_numbers_pack(&las->numbers, records, las->header.record_bytes, part,
                                 las->packed + done_count * stride);
        done_count += part;
    }
    *count = done_count;
done:
    return status;
}

static void close_reader(void *state)
{
    las_reader *las = state;
    stp_source_close(&las->source);
    stp_laz_close(&las->laz);
    stp_las_records_free(&las->records);
    stp_las_notes_free(&las->notes);
    free(las->unpacked);
    free(las->packed);
}

static const uint8_t *numbers_read(const void *state)
{
    return ((const las_reader *)state)->packed;
}

static stp_status open_file(las_reader *las, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_las_header *header = &las->header;
    STP_TRY(stp_source_open(&las->source, path, err));
    STP_TRY(stp_las_header_read(header, &las->source, err));
    STP_TRY(stp_las_records_read(&las->records, header, &las->source, err));
    const size_t fit = STP_LAS_BLOCK_BYTES / header->record_bytes;
    las->block_points = fit < 1 ? 1 : fit < STP_LAS_BLOCK_POINTS ? fit : STP_LAS_BLOCK_POINTS;
    if (header->compressed) {
        const stp_laz_params params = {
            .source = &las->source, .header = header, .record = &las->records.kept[STP_LAS_LASZIP]};
        STP_TRY(stp_laz_open(&las->laz, &params, err));
        STP_TRY(stp_alloc(&las->unpacked, las->block_points, header->record_bytes, "records", err));
    }
    STP_TRY(find_depth(las, err));
    STP_TRY(stp_las_notes_make(&las->notes, header, &las->records, &las->depth, las->keeps_numbers,
                               las->source.size, err));
    snprintf(las->format, sizeof las->format, "%s 1.%u point format %u",
             header->compressed ? "LAZ" : "LAS", header->minor_version, header->point_format);
done:
    return status;
}

static stp_status open_reader(void *state, stp_scan_info *info, const char *path,
                              const stp_scan_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    las_reader *las = state;
    las->keeps_numbers = params->numbers;
    las->source.descriptor = -1;
    STP_TRY(open_file(las, path, err));
    const bool colour = las->header.format->rgb > 0 && las->depth.colour != STP_LAS_COLOUR_NONE;
    info->format = las->format;
    info->point_count = las->header.point_count;
    info->attributes = STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS;
    info->attributes |= colour ? (uint32_t)STP_POINT_HAS_COLOUR : 0u;
    info->seek_points = las->laz ? stp_laz_chunk_points(las->laz) : 1;
    info->heights = true;
    info->intensity_full = las->depth.intensity_8 ? 255.0 : 65535.0;
    info->coordinate_step =
        fmin(las->header.scale[0], fmin(las->header.scale[1], las->header.scale[2]));
    stp_las_numbers_of_file(&las->numbers, &las->header, &las->records, &las->depth);
    info->extra = &las->numbers.list;
    info->notes = las->notes.list;
    info->note_count = las->notes.count;
done:
    return status;
}

static stp_status seek_reader(void *state, uint64_t point, stp_error *err)
{
    las_reader *las = state;
    las->source.narrow = true;
    return seek_point(las, point, err);
}

const stp_scan_reader stp_las_reader = {sizeof(las_reader), open_reader, read_points,
                                        close_reader,       seek_reader, numbers_read};
