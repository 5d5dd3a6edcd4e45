/* Encodes and decodes segments, whole or a block's part of them. */
#include "formats/chunk/codec/part.h"

#include "formats/chunk/codec/draco_part.h"
#include "formats/chunk/codec/paper.h"
#include "formats/chunk/codec/raw.h"
#include "formats/chunk/codec/square/block_squares.h"
#include "formats/chunk/codec/zstd/zstd_segment.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/patch.h"

/* ---- planes ---- */

static stp_status zstd_encode(const stp_chunk *chunk, int segment, stp_bytes *out, stp_error *err)
{
    const stp_status status = segment == 0 ? stp_zstd_head_encode(chunk, out, err) : STP_OK;
    return status == STP_OK ? stp_zstd_level_encode(chunk, stp_segment_finest(segment), out, err)
                            : status;
}

static stp_status zstd_decode(const uint8_t *bytes, size_t size, int segment, uint32_t child_count,
                              stp_chunk *chunk, stp_chunk_scratch *scratch, stp_error *err)
{
    stp_status status = STP_OK;
    size_t used = 0;
    STP_TRY(stp_chunk_scratch_reserve(scratch, stp_zstd_scratch_bytes(chunk, segment), err));
    if (segment == 0) {
        STP_TRY(stp_zstd_patches_decode(bytes, size, chunk->patches, chunk->patch_count,
                                        chunk->linked, scratch, &used, err));
        STP_TRY(stp_patches_take(chunk, child_count, err));
        stp_zstd_vertices_decode(chunk, scratch);
    }
    STP_TRY(stp_zstd_level_decode(bytes + used, size - used, stp_segment_finest(segment), chunk,
                                  scratch, err));
done:
    return status;
}

/* ---- the paper's maps ---- */

static stp_status paper_encode(const stp_chunk *chunk, int segment, stp_bytes *out, stp_error *err)
{
    stp_block_squares squares = {0};
    stp_status status = stp_block_squares_find(chunk, segment, &squares, err);
    if (status == STP_OK)
        status = stp_paper_encode(chunk, segment, squares.of, squares.found ? &squares.map : NULL,
                                  out, err);
    stp_block_squares_clear(&squares);
    return status;
}

/* ---- all codecs ---- */

stp_status stp_part_encode(const stp_chunk *chunk, int segment, stp_codec codec, stp_bytes *out,
                           stp_error *err)
{
    switch (codec) {
    case STP_CODEC_RAW:
        return stp_raw_encode(chunk, segment, out, err);
    case STP_CODEC_DRACO:
        return stp_draco_part_encode(chunk, segment, out, err);
    case STP_CODEC_ZSTD:
        return zstd_encode(chunk, segment, out, err);
    case STP_CODEC_PAPER:
        return paper_encode(chunk, segment, out, err);
    default:
        return stp_error_set(err, STP_INVALID_ARGUMENT, "codec %d does not exist", (int)codec);
    }
}

stp_status stp_part_decode(const uint8_t *bytes, size_t size, int segment, int codec,
                           uint32_t child_count, stp_chunk *chunk, stp_chunk_scratch *scratch,
                           stp_error *err)
{
    stp_status status = STP_OK;
    if (codec == STP_CODEC_RAW)
        status = stp_raw_decode(bytes, size, segment, child_count, chunk, scratch->shares, err);
    else if (codec == STP_CODEC_DRACO)
        status =
            stp_draco_part_decode(bytes, size, segment, child_count, chunk, scratch->shares, err);
    else if (codec == STP_CODEC_ZSTD)
        status = zstd_decode(bytes, size, segment, child_count, chunk, scratch, err);
    else if (codec == STP_CODEC_PAPER)
        status = stp_paper_decode(bytes, size, segment, child_count, chunk, scratch->shares, err);
    else
        status = stp_error_set(err, STP_UNSUPPORTED,
                               "codec %d is not known to this program: use a newer stipple", codec);
    return status == STP_OK && stp_segment_finest(segment) == 0
               ? stp_patches_check_kinds(chunk, err)
               : status;
}
