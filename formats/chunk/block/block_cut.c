/* Cuts chunks into blocks. */
#include "formats/chunk/block/block_cut.h"

#include "base/memory.h"
#include "base/sort.h"

#include <stdlib.h>

/* The least level-0 samples of a block, by codec without blocks: about 8 patches of Draco, 130 of
 * zstd. A block costs some 100 bytes of Draco, half of them its record, and 1500 of zstd, most of
 * them tables of symbols. So most blocks of Draco are what one patch of the parent stands for, and
 * files of zstd grow by at most 4 %. Maps have the same blocks in both their codecs. */
static const uint32_t samples_least[STP_CODEC_COUNT] = {[STP_CODEC_RAW] = 3072,
                                                        [STP_CODEC_DRACO] = 350,
                                                        [STP_CODEC_ZSTD] = 6800,
                                                        [STP_CODEC_PAPER] = 350};

uint32_t stp_block_samples_least(stp_codec codec)
{
    return samples_least[stp_codec_of_part(codec)];
}

stp_status stp_chunk_cut(stp_chunk *chunk, const uint32_t *run_ends, uint32_t run_count,
                         uint32_t least, stp_error *err)
{
    const uint32_t *samples = chunk->level_begin[0], total = samples[chunk->patch_count];
    uint32_t *ends = NULL, count = 0, begin = 0;
    stp_status status = stp_alloc(&ends, run_count, sizeof *ends, "blocks", err);
    if (status != STP_OK)
        return status;
    for (uint32_t r = 0; r + 1 < run_count; r++)
        if (run_ends[r] > begin && run_ends[r] < chunk->patch_count &&
            samples[run_ends[r]] - samples[begin] >= least &&
            total - samples[run_ends[r]] >= least / 2)
            begin = ends[count++] = run_ends[r];
    ends[count++] = chunk->patch_count;
    free(chunk->block_ends);
    chunk->block_ends = ends;
    chunk->block_count = count;
    return STP_OK;
}

stp_status stp_chunk_cut_by_parent(stp_chunk *chunk, const stp_chunk *parent, uint32_t child,
                                   uint32_t least, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *ends = NULL, count = 0;
    uint64_t sum = 0;
    STP_TRY(stp_alloc(&ends, parent->patch_count, sizeof *ends, "runs of patches", err));
    for (uint32_t i = 0; i < parent->patch_count; i++) {
        const stp_patch *patch = &parent->patches[i];
        if (patch->child != child)
            continue;
        ends[count++] = (uint32_t)patch->first_below + patch->counts[0];
        sum += patch->counts[0];
    }
    if (count == 0 || sum != chunk->patch_count)
        goto done;
    stp_sort_u32(ends, count);
    if (ends[count - 1] == chunk->patch_count)
        STP_TRY(stp_chunk_cut(chunk, ends, count, least, err));
done:
    free(ends);
    return status;
}
