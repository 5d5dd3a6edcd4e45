/* Packs and unpacks zstd frames (RFC 8878) in memory.
 *
 * Packing chooses where blocks end, so that each block has codes of its own. Unpacking takes one
 * frame of a known size, trusts nothing in it, and allocates nothing. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_ZSTD_ZSTD_FRAME_H
#define STP_FORMATS_CHUNK_CODEC_ZSTD_ZSTD_FRAME_H

#include "formats/chunk/codec/table/column.h"

#include <stdint.h>

/* Size of the memory for unpacking, aligned for pointers, and zstd's context made in that memory.
 * Make the context once for any number of frames: zstd asks the processor for its features, and
 * that takes longer than a small frame. The context owns nothing. NULL if zstd refuses. */
size_t stp_zstd_workspace_bytes(void);
void *stp_zstd_context(void *workspace);

/* Appends a frame of `bytes`. ends: where blocks end at the latest; the last is the size. Errors:
 * OUT_OF_MEMORY, INTERNAL (zstd fails). */
stp_status stp_zstd_pack(const uint8_t *bytes, const size_t *ends, size_t end_count, stp_bytes *out,
                         stp_error *err);

/* Unpacks a frame of `size` bytes whose content is exactly out_bytes. Errors: CORRUPT. */
stp_status stp_zstd_unpack(const uint8_t *frame, size_t size, uint8_t *out, size_t out_bytes,
                           void *context, stp_error *err);

/* Size of the frame at the start of `bytes`, and of its content; 0 if there is no frame. */
size_t stp_zstd_frame_bytes(const uint8_t *bytes, size_t left, uint64_t *content_bytes);

#endif
