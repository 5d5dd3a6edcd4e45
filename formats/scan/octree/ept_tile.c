/* Reads tiles of an Entwine Point Tile set. */
#include "formats/scan/octree/ept_tile.h"

#include "base/memory.h"
#include "formats/scan/octree/ept_records.h"

#include <errno.h>
#include <stdlib.h>
#include <zstd.h>

#define BLOCK_BYTES ((size_t)1 << 16)
#define BLOCK_POINTS 1024u
/* Packed bytes that zstd gets at once. */
#define PACKED_BYTES ((size_t)1 << 16)
/* A frame may look back by so many bytes: what zstd's own program takes. */
#define WINDOW_BITS 27

static stp_status wrong_count(const stp_ept_tile *tile, uint64_t found, const stp_octree_node *node,
                              stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: has %llu points, and the hierarchy says %u: one of them was cut or "
                         "is of another set; copy the whole set again",
                         tile->file.name, (unsigned long long)found, node->count);
}

/* ---- opening ---- */

static stp_status open_laszip(stp_ept_tile *tile, const stp_octree_node *node, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_las_stream_params params = {
        .path = tile->file.path, .name = tile->file.name, .all_fields = tile->all_fields};
    stp_las_stream_close(&tile->las);
    tile->las = (stp_las_stream){.source.descriptor = -1};
    STP_TRY(stp_las_stream_open(&tile->las, &params, err));
    const stp_las_header *header = &tile->las.header;
    if (header->point_count != node->count)
        return wrong_count(tile, header->point_count, node, err);
    if (stp_ept_has_colours(tile->header) && header->format->rgb == 0)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: its points (format %u) have no colours, and the schema of "
                             "ept.json has: it is of another set; copy the whole set again",
                             tile->file.name, header->point_format);
    tile->block_points = tile->las.block_points;
done:
    return status;
}

static stp_status begin_frame(stp_ept_tile *tile, stp_error *err)
{
    if (!tile->zstd)
        tile->zstd = ZSTD_createDCtx();
    if (!tile->zstd ||
        ZSTD_isError(ZSTD_DCtx_reset(tile->zstd, ZSTD_reset_session_and_parameters)) ||
        ZSTD_isError(ZSTD_DCtx_setParameter(tile->zstd, ZSTD_d_windowLogMax, WINDOW_BITS)))
        return stp_error_set(err, STP_OUT_OF_MEMORY, "%s: no memory for zstd", tile->file.name);
    tile->frame_ended = false;
    return STP_OK;
}

static stp_status open_records(stp_ept_tile *tile, const stp_octree_node *node, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t record = tile->header->record_bytes;
    const size_t fit = BLOCK_BYTES / record;
    tile->block_points = fit < 1 ? 1 : fit < BLOCK_POINTS ? fit : BLOCK_POINTS;
    stp_source_close(&tile->source);
    STP_TRY(stp_source_open(&tile->source, tile->file.path, err));
    tile->source.path = tile->file.name;
    if (tile->header->packing == STP_EPT_ZSTANDARD) {
        if (!tile->records)
            STP_TRY(stp_alloc(&tile->records, tile->block_points, record, "records", err));
        STP_TRY(begin_frame(tile, err));
    } else if (tile->source.size != (uint64_t)node->count * record) {
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: has %llu bytes, and %u points of %u bytes, as the hierarchy "
                               "and ept.json say, have %llu: it was cut or is of another set; copy "
                               "the whole set again",
                               tile->file.name, (unsigned long long)tile->source.size, node->count,
                               record, (unsigned long long)node->count * record);
    }
done:
    return status;
}

stp_status stp_ept_tile_open(stp_ept_tile *tile, const stp_octree_node *node, stp_error *err)
{
    static const char *const endings[] = {".laz", ".bin", ".zst"};
    stp_status status = STP_OK;
    tile->left = 0;
    STP_TRY(stp_ept_files_tile(tile->files, node->key, endings[tile->header->packing], &tile->file,
                               err));
    STP_TRY(tile->header->packing == STP_EPT_LASZIP ? open_laszip(tile, node, err)
                                                    : open_records(tile, node, err));
    tile->left = node->count;
done:
    return status;
}

void stp_ept_tile_close(stp_ept_tile *tile)
{
    stp_las_stream_close(&tile->las);
    stp_source_close(&tile->source);
    (void)ZSTD_freeDCtx(tile->zstd);
    free(tile->records);
    stp_ept_tile_file_close(&tile->file);
    tile->zstd = NULL;
    tile->records = NULL;
}

/* ---- reading ---- */

static stp_status bad_frame(const stp_ept_tile *tile, const char *what, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: byte %llu: %s: it was cut or damaged, or is of another set; copy the "
                         "whole set again",
                         tile->source.path, (unsigned long long)tile->source.offset, what);
}

/* Unpacks until `out` is full; less only at the frame's end. */
static stp_status unpack(stp_ept_tile *tile, ZSTD_outBuffer *out, stp_error *err)
{
    stp_status status = STP_OK;
    while (out->pos < out->size && !tile->frame_ended) {
        const unsigned char *packed;
        size_t available;
        STP_TRY(stp_source_peek(&tile->source, PACKED_BYTES, &packed, &available, err));
        ZSTD_inBuffer in = {packed, available, 0};
        const size_t before = out->pos, left = ZSTD_decompressStream(tile->zstd, out, &in);
        if (ZSTD_isError(left))
            return bad_frame(tile, ZSTD_getErrorName(left), err);
        stp_source_consume(&tile->source, in.pos);
        /* A frame may follow another. */
        tile->frame_ended = left == 0 && tile->source.offset == tile->source.size;
        if (!tile->frame_ended && available == 0 && out->pos == before)
            return bad_frame(tile, "its frame of zstd ends too early", err);
    }
done:
    return status;
}

/* Nothing may follow the last point. */
static stp_status check_end(stp_ept_tile *tile, stp_error *err)
{
    stp_status status = STP_OK;
    unsigned char more;
    ZSTD_outBuffer out = {&more, 1, 0};
    STP_TRY(unpack(tile, &out, err));
    if (out.pos > 0 || tile->source.offset != tile->source.size)
        status = bad_frame(tile, "it has more points than the hierarchy says", err);
done:
    return status;
}

static stp_status next_records(stp_ept_tile *tile, size_t count, const unsigned char **records,
                               stp_error *err)
{
    stp_status status = STP_OK;
    const size_t bytes = count * tile->header->record_bytes;
    size_t got = 0;
    if (tile->header->packing == STP_EPT_ZSTANDARD) {
        ZSTD_outBuffer out = {tile->records, bytes, 0};
        STP_TRY(unpack(tile, &out, err));
        got = out.pos;
        if (got == bytes && tile->left == count)
            STP_TRY(check_end(tile, err));
        *records = tile->records;
    } else {
        STP_TRY(stp_source_peek(&tile->source, bytes, records, &got, err));
        stp_source_consume(&tile->source, got);
    }
    if (got < bytes)
        status = bad_frame(tile, "it has fewer points than the hierarchy says", err);
done:
    return status;
}

stp_status stp_ept_tile_read(stp_ept_tile *tile, const stp_las_depth *depth, stp_point *points,
                             size_t capacity, size_t *count, stp_las_seen *seen, stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned char *records;
    size_t part = capacity < tile->block_points ? capacity : tile->block_points;
    part = part < tile->left ? part : (size_t)tile->left;
    *count = 0;
    if (part == 0)
        return STP_OK;
    if (tile->header->packing == STP_EPT_LASZIP) {
        STP_TRY(stp_las_stream_next(&tile->las, part, &records, err));
        if (seen)
            stp_las_depth_look(seen, &tile->las.header, records, part);
        stp_las_decode(&tile->las.header, depth, tile->header->keeps_withheld, records, points,
                       part);
        tile->read_bytes = tile->las.header.record_bytes;
    } else {
        STP_TRY(next_records(tile, part, &records, err));
        if (seen)
            stp_ept_records_look(seen, tile->header, records, part);
        stp_ept_records_decode(tile->header, depth, records, points, part);
        tile->read_bytes = tile->header->record_bytes;
    }
    tile->read = records;
    tile->left -= part;
    *count = part;
done:
    return status;
}
