/* Segments of codec 2: byte planes in zstd frames.
 *
 * formats/SPEC.md, "Codec 2", is the layout. Decoding writes only into the chunk and the scratch
 * memory, and treats every byte as hostile. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_ZSTD_ZSTD_SEGMENT_H
#define STP_FORMATS_CHUNK_CODEC_ZSTD_ZSTD_SEGMENT_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/table/column.h"

/* The contract is that of part.h. */
stp_status stp_zstd_part_encode(const stp_chunk *chunk, int segment, stp_bytes *out,
                                stp_error *err);
stp_status stp_zstd_part_decode(const uint8_t *bytes, size_t size, int segment,
                                uint32_t child_count, stp_chunk *chunk, stp_chunk_scratch *scratch,
                                stp_error *err);

/* For a payload of codec 2 without its directory entry: */

/* Scratch memory for its patches and patch vertices, aligned for pointers. */
size_t stp_zstd_head_scratch_bytes(uint32_t patch_count, bool linked);
/* Decodes the patches at the start of segment 0, without checking them. *used: bytes of patches and
 * patch vertices together. Errors: CORRUPT. */
stp_status stp_zstd_patches_decode(const uint8_t *bytes, size_t size, stp_patch *patches,
                                   uint32_t patch_count, bool linked, stp_chunk_scratch *scratch,
                                   size_t *used, stp_error *err);
/* The bytes of a level of this many families, derived from the bytes there; 0 if there is no level.
 */
size_t stp_zstd_level_bytes(const uint8_t *bytes, size_t left, uint32_t families);

#endif
