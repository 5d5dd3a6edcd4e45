/* Blocks: what is chosen, fetched, decoded, drawn and evicted by itself.
 *
 * A block is a run of patches of one chunk, about 15 of them (Draco) or 150 (zstd), with all their
 * levels. The blocks of a chunk follow each other and hold each of its patches once. A patch of a
 * linked parent refers to patches of one block only. A chunk of version 1 is one block. Threads:
 * any, as with chunk_file.h.
 */
#ifndef STP_FORMATS_CHUNK_BLOCK_BLOCK_H
#define STP_FORMATS_CHUNK_BLOCK_BLOCK_H

#include "formats/chunk/chunk_file.h"

/* A block's part of a segment. */
typedef struct stp_block_part {
    uint64_t offset; /* in the file */
    uint32_t bytes;
    uint32_t hash; /* bits 0-31 of the bytes' xxh3-64 */
} stp_block_part;

/* Enough to cull, choose and read a block. Floats are relative to the chunk's origin. Index l of
 * the level arrays is the level; s of parts the segment. */
typedef struct stp_block {
    uint32_t chunk;       /* its id */
    uint32_t first_patch; /* among the chunk's patches */
    uint32_t patch_count;
    uint32_t sample_count[STP_LEVEL_COUNT];
    stp_block_part parts[STP_SEGMENT_COUNT];
    uint8_t flags; /* STP_PATCH_TWO_SIDED if any patch is; STP_CHUNK_CLOSED if all are */
    vec3s box_min, box_max;
    vec3s cone_axis;
    float cone_angle; /* radians; >= pi: normals in all directions */
    float error[STP_LEVEL_COUNT];
    float tangential_error[STP_LEVEL_COUNT];
    float colour_error[STP_LEVEL_COUNT]; /* 0..255 */
    float radius_max;
} stp_block;

/* World box of a block; origin: its chunk's. */
static inline stp_dbox stp_block_box(const stp_block *block, stp_dvec3 origin)
{
    return (stp_dbox){stp_dvec3_add(origin, stp_dvec3_from_float(block->box_min)),
                      stp_dvec3_add(origin, stp_dvec3_from_float(block->box_max))};
}

/* The number of blocks of a chunk. Errors: as stp_chunk_file_entry. */
stp_status stp_chunk_file_block_count(stp_chunk_file *file, uint32_t id, uint32_t *out,
                                      stp_error *err);
/* Fills out[stp_chunk_file_block_count]. Errors: as stp_chunk_file_entry. */
stp_status stp_chunk_file_blocks(stp_chunk_file *file, uint32_t id, stp_block *out, stp_error *err);

/* Appends the records of a chunk's blocks, checked, those of a table of wide records made smaller.
 * Errors: as stp_chunk_file_entry, LIMIT (a part is too large), OUT_OF_MEMORY. */
stp_status stp_chunk_file_records(stp_chunk_file *file, uint32_t id, struct stp_bytes *out,
                                  stp_error *err);

/* All patches of a chunk as one block: what a chunk is whose codec has no blocks. */
stp_block stp_block_of_entry(const stp_chunk_entry *entry, uint32_t id);
/* Gives an entry the block's box, cone and errors in place of the chunk's. */
void stp_block_describe(const stp_block *block, stp_chunk_entry *entry);
/* Whether a block's flags and greatest radius hold for one of its patches: NULL, or what is
 * wrong. */
const char *stp_block_fault(const stp_block *block, const stp_patch *patch);

/* A block's payload: its parts of segments 0, 1, 2, one behind the other. The first
 * stp_block_payload_bytes are what decoding to a level needs. */
uint32_t stp_block_payload_bytes(const stp_block *block, int finest_level);
/* Reads bytes [begin, end) of a block's payload. From a server, asks once more for parts that lie
 * whole in this range and fail their checksums. Errors: as stp_chunk_file_fetch. */
stp_status stp_block_fetch(stp_chunk_file *file, const stp_block *block, uint32_t begin,
                           uint32_t end, uint8_t *out, stp_error *err);
/* Checks and decodes a payload's first bytes, as stp_chunk_file_decode does. *out holds the block's
 * patches alone; `child` and `first_below` of a patch still refer to the whole child chunk. */
stp_status stp_block_decode(stp_chunk_file *file, const stp_block *block, int finest_level,
                            const uint8_t *payload, stp_chunk_scratch *scratch, stp_chunk **out,
                            stp_error *err);
/* Memory of a block decoded to finest_level, bytes. */
size_t stp_block_memory_bytes(const stp_block *block, int finest_level);

#endif
