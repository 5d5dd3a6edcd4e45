/* Segments of codec 2: byte planes in zstd frames.
 *
 * formats/SPEC.md, "Codec 2", is the layout. Decoding writes into the chunk and the scratch memory
 * alone; every byte is taken as hostile. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_ZSTD_SEGMENT_H
#define STP_FORMATS_CHUNK_CODEC_ZSTD_SEGMENT_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/column.h"

/* Appends tables of patches and vertices: what segment 0 begins with. Errors: OUT_OF_MEMORY,
 * INTERNAL (zstd). */
stp_status stp_zstd_head_encode(const stp_chunk *chunk, stp_bytes *out, stp_error *err);
/* Appends a level (0 to 2). Errors: likewise. */
stp_status stp_zstd_level_encode(const stp_chunk *chunk, int level, stp_bytes *out, stp_error *err);

/* Scratch memory that decoding a segment of this chunk needs, aligned for pointers. The chunk's
 * patch_count and the last elements of level_begin are set. */
size_t stp_zstd_scratch_bytes(const stp_chunk *chunk, int segment);
/* And for patches and vertices alone. */
size_t stp_zstd_head_scratch_bytes(uint32_t patch_count, bool linked);

/* Decodes the patches at the start of segment 0; they are not checked yet. *used becomes the bytes
 * of the head, vertices included. Errors: CORRUPT. */
stp_status stp_zstd_patches_decode(const uint8_t *bytes, size_t size, stp_patch *patches,
                                   uint32_t patch_count, bool linked, stp_chunk_scratch *scratch,
                                   size_t *used, stp_error *err);
/* Then the vertices, from what the function above left in the scratch memory. */
void stp_zstd_vertices_decode(stp_chunk *chunk, stp_chunk_scratch *scratch);
/* Decodes a level that takes all of `size` bytes. Errors: CORRUPT. */
stp_status stp_zstd_level_decode(const uint8_t *bytes, size_t size, int level, stp_chunk *chunk,
                                 stp_chunk_scratch *scratch, stp_error *err);

/* For a payload without its directory entry: the bytes of a level of so many families, told from
 * what is there; 0 if there is none. */
size_t stp_zstd_level_bytes(const uint8_t *bytes, size_t left, uint32_t families);

#endif
