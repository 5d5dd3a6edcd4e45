/* Chooses the levels of a block by patch. */
#include "runtime/stream/patch_levels.h"

#include "base/memory.h"
#include "runtime/cut/need.h"

#include <stdlib.h>
#include <string.h>

/* A patch gets the level that it will ask for when it is so many times as large in the picture, so
 * that a small motion loads nothing. A statue of 4 M, whole: 142 bytes a drawn sample, 129
 * with 1.4, but then a flight decodes a tenth more. */
#define TIMES_AHEAD 2.0f

/* Lists the levels that a resident block's patches ask for, and takes what they leave out off
 * sample_count. Returns whether any leaves out something. */
static bool list_levels(uint8_t *out, uint32_t sample_count[STP_LEVEL_COUNT],
                        const stp_scene *scene, const stp_gpu_frame *frame, stp_dvec3 eye,
                        const stp_resident *resident, int finest)
{
    const stp_gpu_chunk chunk = stp_scene_record(scene, resident->block, finest, eye);
    bool any = false;
    stp_gpu_frame ahead = *frame;
    ahead.quality[0] /= TIMES_AHEAD;
    ahead.quality[1] /= TIMES_AHEAD;
    for (uint32_t p = 0; p < resident->placement.patches.count; p++) {
        const stp_mirror_patch *patch = &resident->mirror.patches[p];
        const int asked = stp_level_asked(&ahead, &chunk, patch, finest);
        out[p] = (uint8_t)(asked < STP_NEED_HEADERS ? asked : STP_NEED_HEADERS);
        for (int l = finest; l < out[p]; l++)
            sample_count[l] -= patch->count[l];
        any = any || out[p] > finest;
    }
    return any;
}

stp_status stp_patch_levels_choose(uint8_t **out, uint32_t sample_count[STP_LEVEL_COUNT],
                                   const stp_scene *scene, const stp_gpu_frame *frame,
                                   stp_dvec3 eye, const stp_want *want,
                                   const stp_resident *resident, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *levels = NULL;
    const stp_block *block = &scene->blocks[want->block];
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        sample_count[l] = l >= want->finest ? block->sample_count[l] : 0;
    if (resident == NULL || want->finest >= STP_NEED_HEADERS || frame->quality[0] <= 0.0f)
        return STP_OK;
    STP_TRY(stp_alloc(&levels, block->patch_count, 1, "levels of patches", err));
    if (list_levels(levels, sample_count, scene, frame, eye, resident, want->finest)) {
        *out = levels;
        levels = NULL;
    }
done:
    free(levels);
    return status;
}

bool stp_patch_levels_lack(const stp_scene *scene, const stp_gpu_frame *frame, stp_dvec3 eye,
                           const stp_resident *resident, int finest)
{
    const stp_gpu_chunk chunk = stp_scene_record(scene, resident->block, finest, eye);
    for (uint32_t p = 0; p < resident->placement.patches.count; p++) {
        const stp_mirror_patch *patch = &resident->mirror.patches[p];
        if (patch->finest > finest && stp_level_asked(frame, &chunk, patch, finest) < patch->finest)
            return true;
    }
    return false;
}

void stp_patch_levels_keep(stp_chunk *chunk, const uint8_t *finest)
{
    for (int l = chunk->finest_level; l < STP_NEED_HEADERS; l++) {
        uint32_t *begin = chunk->level_begin[l], at = 0, from = begin[0];
        for (uint32_t p = 0; p < chunk->patch_count; p++) {
            const uint32_t end = begin[p + 1], count = l >= finest[p] ? end - from : 0;
            memmove(chunk->samples[l] + at, chunk->samples[l] + from,
                    count * sizeof *chunk->samples[l]);
            begin[p] = at;
            at += count;
            from = end;
        }
        begin[chunk->patch_count] = at;
    }
}
