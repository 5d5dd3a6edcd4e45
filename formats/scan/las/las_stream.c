/* Reads the records of a LAS or LAZ file and decodes them. */
#include "formats/scan/las/las_stream.h"

#include "base/memory.h"
#include "formats/scan/las/copc.h"
#include "formats/scan/las/las_bytes.h"
#include "formats/scan/octree/octree.h"
#include "formats/scan/remote/mirror.h"

#include <assert.h>
#include <stdlib.h>

/* Holds a block of records for most files. Longer records come in smaller blocks. */
#define STP_LAS_BLOCK_BYTES ((size_t)1 << 16)
#define STP_LAS_BLOCK_POINTS 1024u

/* Offsets of fields in a record, the same in all formats. */
enum { AT_INTENSITY = 12, AT_CLASS_AND_FLAGS = 15, AT_EXTENDED_CLASS = 16 };

/* ---- opening ---- */

/* Whether only some nodes of an octree are read. */
static bool chooses(const stp_scan_region *region)
{
    return region && (region->bounded || region->resolution > 0.0);
}

static stp_status open_packed(stp_las_stream *las, const stp_las_stream_params *params,
                              stp_error *err)
{
    stp_status status = STP_OK;
    stp_laz_chunks chosen = {0};
    stp_laz_params laz = {.source = &las->source,
                          .header = &las->header,
                          .record = &las->records.kept[STP_LAS_LASZIP],
                          .all_fields = params->all_fields};
    if (chooses(params->region) && stp_copc_is(&las->header, &las->records)) {
        STP_TRY(stp_copc_choose(&chosen, &las->header.point_count, &las->header, &las->records,
                                params->region, &las->source, err));
        laz.chosen = &chosen;
    } else if (params->mirror) {
        STP_TRY(stp_mirror_need(params->mirror, 0, UINT64_MAX, err));
    }
    STP_TRY(stp_laz_team_open(&las->laz, &laz, params->pool, err));
    STP_TRY(stp_alloc(&las->unpacked, las->block_points, las->header.record_bytes, "records", err));
done:
    stp_laz_chunks_free(&chosen);
    return status;
}

stp_status stp_las_stream_open(stp_las_stream *las, const stp_las_stream_params *params,
                               stp_error *err)
{
    stp_status status = STP_OK;
    stp_las_header *header = &las->header;
    STP_TRY(stp_source_open(&las->source, params->path, err));
    las->source.path = params->name ? params->name : params->path;
    las->source.mirror = params->mirror;
    STP_TRY(stp_las_header_read(header, &las->source, params->salvage, err));
    STP_TRY(stp_las_records_read(&las->records, header, &las->source, err));
    const size_t fit = STP_LAS_BLOCK_BYTES / header->record_bytes;
    las->block_points = fit < 1 ? 1 : fit < STP_LAS_BLOCK_POINTS ? fit : STP_LAS_BLOCK_POINTS;
    if (params->region && params->region->resolution > 0.0 && !stp_copc_is(header, &las->records))
        return stp_octree_missing(las->source.path, err);
    if (header->compressed)
        STP_TRY(open_packed(las, params, err));
    STP_TRY(stp_las_stream_seek(las, 0, err));
done:
    return status;
}

void stp_las_stream_close(stp_las_stream *las)
{
    stp_source_close(&las->source);
    stp_laz_team_close(&las->laz);
    stp_las_records_free(&las->records);
    free(las->unpacked);
    las->unpacked = NULL;
}

/* ---- records ---- */

stp_status stp_las_stream_seek(stp_las_stream *las, uint64_t point, stp_error *err)
{
    las->next = point;
    if (las->laz)
        return las->header.point_count > 0 ? stp_laz_team_seek(las->laz, point, err) : STP_OK;
    /* No overflow: the header was checked against the file's size. */
    stp_source_seek(&las->source, las->header.point_offset + point * las->header.record_bytes, 0);
    return STP_OK;
}

stp_status stp_las_stream_next(stp_las_stream *las, size_t count, const unsigned char **records,
                               stp_error *err)
{
    stp_status status = STP_OK;
    const size_t bytes = count * las->header.record_bytes;
    if (las->laz) {
        STP_TRY(stp_laz_team_read(las->laz, las->unpacked, count, err));
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

/* ---- points ---- */

static void decode_colours(const stp_las_header *header, stp_las_colour_depth depth,
                           const unsigned char *record, stp_point *points, size_t count)
{
    const size_t stride = header->record_bytes;
    record += header->format->rgb;
    for (size_t i = 0; i < count; i++, record += stride)
        for (int k = 0; k < 3; k++)
            points[i].rgb[k] = stp_las_colour(stp_las_u16(record + 2 * k), depth);
}

static bool is_withheld(const unsigned char *record, bool extended)
{
    return record[AT_CLASS_AND_FLAGS] & (extended ? 0x04 : 0x80);
}

void stp_las_decode(const stp_las_header *header, const stp_las_depth *depth, bool keep_withheld,
                    const unsigned char *records, stp_point *points, size_t count)
{
    const size_t stride = header->record_bytes;
    const bool extended = header->format->extended, narrow = depth->intensity_8;
    const double *scale = header->scale, *offset = header->offset;
    const unsigned char *at = records;
    for (size_t i = 0; i < count; i++, at += stride) {
        const uint16_t intensity = stp_las_u16(at + AT_INTENSITY);
        points[i] = (stp_point){
            .position = {(int32_t)stp_las_u32(at) * scale[0] + offset[0],
                         (int32_t)stp_las_u32(at + 4) * scale[1] + offset[1],
                         (int32_t)stp_las_u32(at + 8) * scale[2] + offset[2]},
            .intensity = narrow ? stp_las_widen(intensity) : intensity,
            .class_id = extended ? at[AT_EXTENDED_CLASS] : at[AT_CLASS_AND_FLAGS] & 0x1f,
            .reject =
                !keep_withheld && is_withheld(at, extended) ? STP_REJECT_INVALID : STP_REJECT_NONE};
    }
    if (header->format->rgb > 0 && depth->colour != STP_LAS_COLOUR_NONE)
        decode_colours(header, depth->colour, records, points, count);
}
