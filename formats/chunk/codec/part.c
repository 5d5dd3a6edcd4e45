/* Chooses the codec of a segment, or of a block's part of it. */
#include "formats/chunk/codec/part.h"

#include "formats/chunk/codec/draco_part.h"
#include "formats/chunk/codec/paper.h"
#include "formats/chunk/codec/raw.h"
#include "formats/chunk/codec/zstd/zstd_segment.h"
#include "formats/chunk/sample/patch.h"

stp_status stp_part_encode(const stp_chunk *chunk, int segment, stp_codec codec, stp_bytes *out,
                           stp_error *err)
{
    switch (codec) {
    case STP_CODEC_RAW:
        return stp_raw_encode(chunk, segment, out, err);
    case STP_CODEC_DRACO:
        return stp_draco_part_encode(chunk, segment, out, err);
    case STP_CODEC_ZSTD:
        return stp_zstd_part_encode(chunk, segment, out, err);
    case STP_CODEC_PAPER:
        return stp_paper_encode(chunk, segment, out, err);
    default:
        return stp_error_set(err, STP_INVALID_ARGUMENT, "codec %d does not exist", (int)codec);
    }
}

stp_status stp_part_decode(const uint8_t *bytes, size_t size, int segment, int codec,
                           uint32_t child_count, stp_chunk *chunk, stp_chunk_scratch *scratch,
                           stp_error *err)
{
    stp_shares *shares = scratch->shares;
    stp_status status = STP_OK;
    switch (codec) {
    case STP_CODEC_RAW:
        status = stp_raw_decode(bytes, size, segment, child_count, chunk, shares, err);
        break;
    case STP_CODEC_DRACO:
        status = stp_draco_part_decode(bytes, size, segment, child_count, chunk, shares, err);
        break;
    case STP_CODEC_ZSTD:
        status = stp_zstd_part_decode(bytes, size, segment, child_count, chunk, scratch, err);
        break;
    case STP_CODEC_PAPER:
        status = stp_paper_decode(bytes, size, segment, child_count, chunk, shares, err);
        break;
    default:
        status = stp_error_set(err, STP_UNSUPPORTED,
                               "codec %d is not known to this program: use a newer stipple", codec);
    }
    return status == STP_OK && stp_segment_finest(segment) == 0
               ? stp_patches_check_kinds(chunk, err)
               : status;
}
