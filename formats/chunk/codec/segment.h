/* Encodes and decodes a chunk's payload segments, coarse to fine.
 *
 * A segment of codec STP_CODEC_RAW_BLOCKS, _DRACO_BLOCKS, _ZSTD_BLOCKS or _PAPER is cut into
 * blocks, runs of patches that each decode by themselves (formats/SPEC.md, "Blocks"):
 *
 *   u32 block count | an index row for each block | the blocks' parts, one behind the other
 *
 * A part is what the codec of the same name without blocks makes of these patches alone (part.h).
 *
 * Segment 0: patch headers, level 3, level 2; segment 1: level 1; segment 2: level 0. Each needs
 * the segments before it. Reads no files and compares no checksums; treats every byte as hostile.
 * Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_SEGMENT_H
#define STP_FORMATS_CHUNK_CODEC_SEGMENT_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/table/table.h"

/* A block as the index of segment 0 has it, and where its part of a segment lies. */
typedef struct stp_block_row {
    uint32_t patch_count;
    uint32_t sample_count[STP_LEVEL_COUNT];
    uint32_t begin, bytes; /* of its part, in the segment */
} stp_block_row;

/* Appends a segment's bytes. Blocks end at chunk->block_ends. The chunk must hold the segment's
 * levels and pass stp_patches_check. Errors: OUT_OF_MEMORY, INTERNAL (Draco, zstd),
 * INVALID_ARGUMENT (codec). */
stp_status stp_segment_encode(const stp_chunk *chunk, int segment, stp_codec codec, stp_bytes *out,
                              stp_error *err);
/* Appends the bytes of all segments, encoded block by block: only one block's squares are held at a
 * time. Sets the entry's codec, segment ends and hashes. Errors: those of stp_segment_encode. */
stp_status stp_segments_encode(const stp_chunk *chunk, stp_codec codec, stp_chunk_entry *entry,
                               stp_bytes *out, stp_error *err);

/* Decodes a segment into the chunk's arrays (stp_chunk_create). The caller has set `linked`, and
 * the last elements of level_begin to the counts that must be met. child_count: of the directory
 * entry. scratch grows as needed. Segment 0 of a codec with blocks sets chunk->block_ends. Errors:
 * CORRUPT, UNSUPPORTED (codec), OUT_OF_MEMORY. */
stp_status stp_segment_decode(const uint8_t *bytes, size_t size, int segment, int codec,
                              uint32_t child_count, stp_chunk *chunk, stp_chunk_scratch *scratch,
                              stp_error *err);

/* Bytes of a short row of a segment's index. */
size_t stp_block_row_bytes(const stp_block_row *row, int segment);
/* Bytes of a segment before the parts of its blocks, if its rows are not short. */
static inline uint64_t stp_block_long_index_bytes(uint32_t block_count, int segment)
{
    return 4 + (uint64_t)block_count * (segment == 0 ? 12 : 4);
}
/* Bytes of the segment in blocks that begins at `bytes`, by its index; 0 if they do not fit. */
size_t stp_block_segment_bytes(const uint8_t *bytes, size_t size, int segment);
/* The number of blocks that a segment says it has. Errors: CORRUPT (more than fit). */
stp_status stp_block_count_read(const uint8_t *bytes, size_t size, uint32_t *out, stp_error *err);
/* Reads the index of a segment into rows[count]. Rows of segment 0 get all members, those of others
 * only begin and bytes. The parts fill the segment. Errors: CORRUPT. */
stp_status stp_block_rows_read(const uint8_t *bytes, size_t size, int segment, stp_block_row *rows,
                               uint32_t count, stp_error *err);

#endif
