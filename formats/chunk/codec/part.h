/* Encodes and decodes segments without blocks (STP_CODEC_RAW, _DRACO, _ZSTD): the segment of a
 * chunk, or a block's part of it (also STP_CODEC_PAPER). The chunk is then the block's patches
 * alone.
 *
 * Segment 0: patch headers, level 3, level 2; segment 1: level 1; segment 2: level 0. Each needs
 * the segments before it. Treats every byte as hostile. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_PART_H
#define STP_FORMATS_CHUNK_CODEC_PART_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/table/table.h"

/* Coarsest and finest level of a segment. */
static inline int stp_segment_coarsest(int segment)
{
    return segment == 0 ? STP_LEVEL_COUNT - 1 : 2 - segment;
}
static inline int stp_segment_finest(int segment)
{
    return 2 - segment;
}

/* As stp_segment_encode. */
stp_status stp_part_encode(const stp_chunk *chunk, int segment, stp_codec codec, stp_bytes *out,
                           stp_error *err);
/* As stp_segment_decode. */
stp_status stp_part_decode(const uint8_t *bytes, size_t size, int segment, int codec,
                           uint32_t child_count, stp_chunk *chunk, stp_chunk_scratch *scratch,
                           stp_error *err);

#endif
