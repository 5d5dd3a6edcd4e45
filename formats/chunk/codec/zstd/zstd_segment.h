/* Segments of codec 2: byte planes in zstd frames.
 *
 * formats/SPEC.md, "Codec 2", is the layout. Decoding writes only into the chunk and the scratch
 * memory, and treats every byte as hostile. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_ZSTD_ZSTD_SEGMENT_H
#define STP_FORMATS_CHUNK_CODEC_ZSTD_ZSTD_SEGMENT_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/table/column.h"

/* Appends the tables of patches and patch vertices, with which segment 0 begins. Errors:
 * OUT_OF_MEMORY, INTERNAL (zstd). */
stp_status stp_zstd_head_encode(const stp_chunk *chunk, stp_bytes *out, stp_error *err);
/* Appends a level (0 to 2). Errors: OUT_OF_MEMORY, INTERNAL (zstd). */
stp_status stp_zstd_level_encode(const stp_chunk *chunk, int level, stp_bytes *out, stp_error *err);

/* Scratch memory for decoding a segment of this chunk, aligned for pointers. The chunk's
 * patch_count and the last elements of level_begin must be set. */
size_t stp_zstd_scratch_bytes(const stp_chunk *chunk, int segment);
/* The same for patches and patch vertices alone. */
size_t stp_zstd_head_scratch_bytes(uint32_t patch_count, bool linked);

/* Decodes the patches at the start of segment 0, without checking them. *used: bytes of patches and
 * patch vertices together. Errors: CORRUPT. */
stp_status stp_zstd_patches_decode(const uint8_t *bytes, size_t size, stp_patch *patches,
                                   uint32_t patch_count, bool linked, stp_chunk_scratch *scratch,
                                   size_t *used, stp_error *err);
/* Decodes the patch vertices from what stp_zstd_patches_decode left in the scratch memory. */
void stp_zstd_vertices_decode(stp_chunk *chunk, stp_chunk_scratch *scratch);
/* Decodes a level that takes all of `size` bytes. Errors: CORRUPT. */
stp_status stp_zstd_level_decode(const uint8_t *bytes, size_t size, int level, stp_chunk *chunk,
                                 stp_chunk_scratch *scratch, stp_error *err);

/* For a payload of codec 2 without its directory entry: the bytes of a level of this many families,
 * derived from the bytes there; 0 if there is no level. */
size_t stp_zstd_level_bytes(const uint8_t *bytes, size_t left, uint32_t families);

#endif
