/* A chunk's payload segments, coarse to fine, to and from decoded chunks.
 *
 * Segment 0: patch headers, level 3, level 2; segment 1: level 1; segment 2: level 0. Each needs
 * the segments before it. Does no file access and checks no sums; every byte is taken as hostile.
 * Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_SEGMENT_H
#define STP_FORMATS_CHUNK_CODEC_SEGMENT_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/table.h"

/* Appends a segment's bytes. The chunk must hold the segment's levels and pass stp_patches_check.
 * Errors: OUT_OF_MEMORY, INTERNAL (Draco, zstd), INVALID_ARGUMENT (codec). */
stp_status stp_segment_encode(const stp_chunk *chunk, int segment, stp_codec codec, stp_bytes *out,
                              stp_error *err);

/* Decodes a segment into the chunk's arrays (stp_chunk_create; the last elements of level_begin
 * hold the counts to be met, linked is set). child_count: of the directory entry; scratch grows
 * as it must. Errors: CORRUPT, UNSUPPORTED (codec), OUT_OF_MEMORY. */
stp_status stp_segment_decode(const uint8_t *bytes, size_t size, int segment, int codec,
                              uint32_t child_count, stp_chunk *chunk, stp_chunk_scratch *scratch,
                              stp_error *err);

#endif
