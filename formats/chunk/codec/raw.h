/* Encodes and decodes what codec 0 has: patches and samples as they are in memory, little-endian.
 * Treats every byte as hostile. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_RAW_H
#define STP_FORMATS_CHUNK_CODEC_RAW_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/shares.h"
#include "formats/chunk/codec/table/column.h"

/* Appends the patches. Errors: OUT_OF_MEMORY. */
stp_status stp_raw_patches_encode(const stp_chunk *chunk, stp_bytes *out, stp_error *err);
/* Reads and checks the chunk's patches, and places its levels. Errors: CORRUPT. */
stp_status stp_raw_patches_decode(stp_cursor *c, uint32_t child_count, stp_chunk *chunk,
                                  stp_shares *shares, stp_error *err);

/* As stp_part_encode and stp_part_decode. shares: NULL if nobody asks. */
stp_status stp_raw_encode(const stp_chunk *chunk, int segment, stp_bytes *out, stp_error *err);
stp_status stp_raw_decode(const uint8_t *bytes, size_t size, int segment, uint32_t child_count,
                          stp_chunk *chunk, stp_shares *shares, stp_error *err);

#endif
