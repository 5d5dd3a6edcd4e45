/* Reads LAS and LAZ files as a stream of points. */
#include "formats/scan/las/las.h"

#include "base/memory.h"
#include "formats/scan/las/copc.h"
#include "formats/scan/las/las_notes.h"
#include "formats/scan/las/las_numbers.h"
#include "formats/scan/las/las_stream.h"
#include "formats/scan/value_range.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct las_reader {
    stp_las_stream stream;
    stp_las_depth depth;
    stp_las_notes notes;
    stp_las_numbers numbers;
    bool keeps_numbers, keeps_withheld, salvage;
    uint8_t *packed; /* numbers of the points read last */
    size_t packed_capacity;
    char format[40];
} las_reader;

/* Finds the depths as in las_depth.h and goes back to the first point. */
static stp_status find_depth(las_reader *las, stp_error *err)
{
    stp_status status = STP_OK;
    stp_las_stream *s = &las->stream;
    const unsigned blocks = s->laz ? STP_LAS_SAMPLE_BLOCKS_COMPRESSED : STP_LAS_SAMPLE_BLOCKS;
    const uint64_t total = s->header.point_count;
    stp_las_seen seen = {0};
    for (unsigned block = 0; block < blocks; block++) {
        uint64_t first = stp_spread_begin(total, block, blocks);
        const uint64_t chunk = s->laz ? stp_laz_team_chunk_begin(s->laz, first) : 0;
        first = chunk >= s->next ? chunk : first;  /* nothing before it is unpacked in vain */
        first = first > s->next ? first : s->next; /* else blocks of small files would overlap */
        uint64_t end =
            total - first < STP_LAS_SAMPLE_POINTS ? total : first + STP_LAS_SAMPLE_POINTS;
        if (first == end)
            break;
        const stp_status found = stp_las_stream_seek(s, first, err);
        if (found == STP_CORRUPT && las->salvage)
            break;
        STP_TRY(found);
        while (s->next < end) {
            const uint64_t left = end - s->next;
            const size_t part = left < s->block_points ? (size_t)left : s->block_points;
            const unsigned char *records;
            const stp_status read = stp_las_stream_next(s, part, &records, err);
            if (read == STP_CORRUPT && las->salvage)
                goto cut;
            STP_TRY(read);
            stp_las_depth_look(&seen, &s->header, records, part);
        }
    }
cut:
    las->depth = stp_las_depth_decide(&seen);
    STP_TRY(stp_las_stream_seek(s, 0, err));
done:
    return status;
}

static stp_status read_points(void *state, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    las_reader *las = state;
    stp_las_stream *s = &las->stream;
    size_t done_count = 0;
    const size_t stride = stp_attribute_list_bytes(&las->numbers.list);
    if (las->keeps_numbers)
        STP_TRY(
            stp_grow(&las->packed, &las->packed_capacity, capacity * stride, 1, "attributes", err));
    while (done_count < capacity && s->next < s->header.point_count) {
        const uint64_t left = s->header.point_count - s->next;
        size_t part = capacity - done_count;
        const unsigned char *records;
        part = part < s->block_points ? part : s->block_points;
        part = part < left ? part : (size_t)left;
        STP_TRY(stp_las_stream_next(s, part, &records, err));
        stp_las_decode(&s->header, &las->depth, las->keeps_withheld, records, points + done_count,
                       part);
        if (las->keeps_numbers)
            stp_las_numbers_pack(&las->numbers, records, s->header.record_bytes, part,
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
    stp_las_stream_close(&las->stream);
    stp_las_notes_free(&las->notes);
    free(las->packed);
}

static const uint8_t *numbers_read(const void *state)
{
    return ((const las_reader *)state)->packed;
}

static stp_status open_file(las_reader *las, const char *path, const stp_scan_params *params,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const stp_las_header *header = &las->stream.header;
    const stp_las_stream_params stream = {.path = path,
                                          .region = params->region,
                                          .mirror = params->mirror,
                                          .salvage = params->salvage,
                                          .all_fields = params->numbers,
                                          .pool = params->pool};
    STP_TRY(stp_las_stream_open(&las->stream, &stream, err));
    STP_TRY(find_depth(las, err));
    if (las->stream.laz)
        stp_laz_team_together(las->stream.laz);
    STP_TRY(stp_las_notes_make(&las->notes, header, &las->stream.records, &las->depth,
                               las->keeps_numbers, las->stream.source.size, err));
    snprintf(las->format, sizeof las->format, "%s 1.%u point format %u",
             stp_copc_is(header, &las->stream.records) ? "COPC"
             : header->compressed                      ? "LAZ"
                                                       : "LAS",
             header->minor_version, header->point_format);
done:
    return status;
}

static stp_status open_reader(void *state, stp_scan_info *info, const char *path,
                              const stp_scan_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    las_reader *las = state;
    las->keeps_numbers = params->numbers;
    las->keeps_withheld = params->keep_withheld;
    las->salvage = params->salvage;
    las->stream.source.descriptor = -1;
    STP_TRY(open_file(las, path, params, err));
    const stp_las_header *header = &las->stream.header;
    const bool colour = header->format->rgb > 0 && las->depth.colour != STP_LAS_COLOUR_NONE;
    info->format = las->format;
    info->point_count = header->point_count;
    info->lost_count = header->lost_count;
    info->attributes = STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS;
    info->attributes |= colour ? (uint32_t)STP_POINT_HAS_COLOUR : 0u;
    info->seek_points = las->stream.laz ? stp_laz_team_chunk_points(las->stream.laz) : 1;
    if (stp_copc_is(header, &las->stream.records))
        info->octree_spacing = stp_copc_spacing(&las->stream.records);
    info->heights = true;
    info->intensity_full = las->depth.intensity_8 ? 255.0 : 65535.0;
    info->coordinate_step =
        fmin(fabs(header->scale[0]), fmin(fabs(header->scale[1]), fabs(header->scale[2])));
    stp_las_numbers_of_file(&las->numbers, header, &las->stream.records, &las->depth,
                            las->keeps_withheld);
    info->extra = &las->numbers.list;
    info->notes = las->notes.list;
    info->note_count = las->notes.count;
done:
    return status;
}

static stp_status seek_reader(void *state, uint64_t point, stp_error *err)
{
    las_reader *las = state;
    las->stream.source.narrow = true;
    return stp_las_stream_seek(&las->stream, point, err);
}

const stp_scan_reader stp_las_reader = {sizeof(las_reader), open_reader, read_points,
                                        close_reader,       seek_reader, numbers_read};
