/* Blocks of a file of version 1: each chunk is one block. */
#include "formats/chunk/block.h"

#include <string.h>

stp_status stp_chunk_file_block_count(stp_chunk_file *file, uint32_t id, uint32_t *out,
                                      stp_error *err)
{
    stp_chunk_entry entry;
    stp_status status = stp_chunk_file_entry(file, id, &entry, err);
    if (status == STP_OK)
        *out = 1;
    return status;
}

/* The block that holds all patches of a chunk. */
static stp_block block_of_entry(const stp_chunk_entry *e, uint32_t id)
{
    stp_block block = {
        .chunk = id,
        .patch_count = e->patch_count,
        .flags = (uint8_t)(e->flags & (STP_PATCH_TWO_SIDED | STP_CHUNK_CLOSED)),
        .box_min = e->box_min,
        .box_max = e->box_max,
        .cone_axis = e->cone_axis,
        .cone_angle = e->cone_angle,
        .radius_max = e->radius_max,
    };
    uint32_t begin = 0;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        block.parts[s] = (stp_block_part){.offset = e->offset + begin,
                                          .hash = e->segment_hash[s],
                                          .bytes = e->segment_end[s] - begin};
        begin = e->segment_end[s];
    }
    memcpy(block.sample_count, e->sample_count, sizeof block.sample_count);
    memcpy(block.error, e->error, sizeof block.error);
    memcpy(block.tangential_error, e->tangential_error, sizeof block.tangential_error);
    memcpy(block.colour_error, e->colour_error, sizeof block.colour_error);
    return block;
}

stp_status stp_chunk_file_blocks(stp_chunk_file *file, uint32_t id, stp_block *out, stp_error *err)
{
    stp_chunk_entry entry;
    stp_status status = stp_chunk_file_entry(file, id, &entry, err);
    if (status == STP_OK)
        *out = block_of_entry(&entry, id);
    return status;
}

uint32_t stp_block_payload_bytes(const stp_block *block, int finest_level)
{
    uint32_t bytes = block->parts[0].bytes;
    bytes += finest_level < 2 ? block->parts[1].bytes : 0;
    return bytes + (finest_level < 1 ? block->parts[2].bytes : 0);
}

stp_status stp_block_fetch(stp_chunk_file *file, const stp_block *block, uint32_t begin,
                           uint32_t end, uint8_t *out, stp_error *err)
{
    return stp_chunk_file_fetch(file, block->chunk, begin, end, out, err);
}

stp_status stp_block_decode(stp_chunk_file *file, const stp_block *block, int finest_level,
                            const uint8_t *payload, stp_chunk_scratch *scratch, stp_chunk **out,
                            stp_error *err)
{
    return stp_chunk_file_decode(file, block->chunk, finest_level, payload, scratch, out, err);
}

size_t stp_block_memory_bytes(const stp_block *block, int finest_level)
{
    const stp_chunk_entry entry = {.patch_count = block->patch_count,
                                   .sample_count = {block->sample_count[0], block->sample_count[1],
                                                    block->sample_count[2],
                                                    block->sample_count[3]}};
    return stp_chunk_memory_bytes(&entry, finest_level);
}
