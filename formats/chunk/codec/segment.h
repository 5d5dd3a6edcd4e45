/* Encodes and decodes a chunk's payload segments, coarse to fine.
 *
 * Segment 0: patch headers, level 3, level 2; segment 1: level 1; segment 2: level 0. Each needs
 * the segments before it. Reads no files and compares no checksums; treats every byte as hostile.
 * Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_SEGMENT_H
#define STP_FORMATS_CHUNK_CODEC_SEGMENT_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/table.h"

/* Appends a segment's bytes. The chunk must hold the segment's levels and pass stp_patches_check.
 * Errors: OUT_OF_MEMORY, INTERNAL (Draco, zstd), INVALID_ARGUMENT (codec). */
stp_status stp_segment_encode(const stp_chunk *chunk, int segment, stp_codec codec, stp_bytes *out,
                              stp_error *err);

/* Decodes a segment into the chunk's arrays (stp_chunk_create). The caller has set `linked`, and
 * the last elements of level_begin to the counts that must be met. child_count: of the directory
 * entry. scratch grows as needed. Errors: CORRUPT, UNSUPPORTED (codec), OUT_OF_MEMORY. */
stp_status stp_segment_decode(const uint8_t *bytes, size_t size, int segment, int codec,
                              uint32_t child_count, stp_chunk *chunk, stp_chunk_scratch *scratch,
                              stp_error *err);

#endif
