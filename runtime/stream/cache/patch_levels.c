/* Chooses the levels of a block by patch. */
#include "runtime/stream/cache/patch_levels.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* A patch gets the level that it will ask for when it is so many times as large in the picture, so
 * that a small motion loads nothing. A statue of 4 M, 512 x 512, whole, turned: 65 bytes a drawn
 * sample; 76 with 2, 61 with 1.2. A flight that comes three times as near decodes 1.27 times the
 * blocks of 2, in the same time, since they have fewer samples; with 1.2 it takes 5 % longer. */
#define TIMES_AHEAD 1.4f

/* The finest level that a patch asks for if it is in sight. */
static int asked_in_sight(const stp_gpu_frame *frame, const stp_gpu_chunk *record,
                          const stp_mirror_patch *patch, int finest)
{
    return stp_patch_visible(frame, record, patch) ? stp_level_asked(frame, record, patch, finest)
                                                   : STP_LEVEL_COUNT - 1;
}

/* Whether a patch is left to the block below, which is or will be drawn: none of its levels does.
 */
static bool is_left(const stp_patch_look *look, const stp_gpu_chunk *record,
                    const stp_resident *resident, uint32_t patch)
{
    const stp_patch_brief *brief = &resident->mirror.briefs[patch];
    const stp_rule_bound bound = stp_patch_bound(brief, record);
    const stp_rule_sight sight = stp_rule_look(&look->frame, &bound);
    return !look->ahead && look->below != NULL && brief->block != STP_BLOCK_NONE &&
           look->below->level(look->below->context, brief->block) >= STP_NEED_HEADERS &&
           (stp_scene_entry(look->scene, resident->block)->flags & STP_CHUNK_LINKED) != 0 &&
           !stp_levels_do(&look->frame, &sight, &resident->mirror.patches[patch], 0);
}

static int level_kept(const stp_patch_view *view, const stp_mirror_patch *patch)
{
    const int finest = (int)view->record.finest;
    return view->ahead ? stp_level_asked(&view->frame, &view->record, patch, finest)
                       : asked_in_sight(&view->frame, &view->record, patch, finest);
}

/* Lists the levels that a block's patches ask for, and takes what they leave out off sample_count.
 * Returns whether any leaves out something. resident: NULL if blocks below are not looked for. */
static bool list_levels(uint8_t *out, uint32_t sample_count[STP_LEVEL_COUNT],
                        const stp_patch_view *view, const stp_mirror_patch *patches, uint32_t count,
                        const stp_patch_look *look, const stp_resident *resident)
{
    const int finest = (int)view->record.finest;
    bool any = false;
    for (uint32_t p = 0; p < count; p++) {
        const bool left = resident != NULL && is_left(look, &view->record, resident, p);
        out[p] = (uint8_t)(left ? STP_LEVEL_COUNT - 1 : level_kept(view, &patches[p]));
        for (int l = finest; l < out[p]; l++)
            sample_count[l] -= patches[p].count[l];
        any = any || out[p] > finest;
    }
    return any;
}

/* Lists the levels of patches that are known, unless all get what is wanted. */
static stp_status list_known(stp_load_place *place, uint32_t sample_count[STP_LEVEL_COUNT],
                             const stp_mirror_patch *patches, uint32_t count,
                             const stp_patch_look *look, const stp_resident *resident,
                             stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *levels = NULL;
    STP_TRY(stp_alloc(&levels, count, 1, "levels of patches", err));
    if (list_levels(levels, sample_count, place->view, patches, count, look, resident)) {
        place->finest = levels;
        levels = NULL;
    }
done:
    free(levels);
    return status;
}

stp_status stp_patch_levels_choose(stp_load_place *out, uint32_t sample_count[STP_LEVEL_COUNT],
                                   const stp_patch_look *look, const stp_want *want,
                                   const stp_resident *resident, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_block *block = &look->scene->blocks[want->block];
    const bool ahead = look->ahead;
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        sample_count[l] = l >= want->finest ? block->sample_count[l] : 0;
    if (want->finest >= STP_LEVEL_COUNT - 1 || look->frame.quality[0] <= 0.0f)
        return STP_OK;
    STP_TRY(stp_alloc(&out->view, 1, sizeof *out->view, "levels of patches", err));
    out->view->frame = look->frame;
    out->view->frame.quality[0] /= ahead ? TIMES_AHEAD : 1.0f;
    out->view->frame.quality[1] /= ahead ? TIMES_AHEAD : 1.0f;
    out->view->ahead = ahead;
    out->view->record = stp_scene_record(look->scene, want->block, want->finest, look->eye);
    if (resident != NULL) {
        status = list_known(out, sample_count, resident->mirror.patches, block->patch_count, look,
                            resident, err);
        free(out->view);
        out->view = NULL;
    }
done:
    return status;
}

stp_status stp_patch_levels_leave(stp_load_place *place, stp_mirror_patch *patches,
                                  stp_chunk *chunk, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t all[STP_LEVEL_COUNT] = {0};
    if (place->view != NULL)
        STP_TRY(list_known(place, all, patches, chunk->patch_count, NULL, NULL, err));
    if (place->finest != NULL)
        stp_patch_levels_keep(chunk, place->finest);
    for (uint32_t p = 0; place->finest != NULL && p < chunk->patch_count; p++)
        patches[p].finest = (uint8_t)stp_texels_finest(chunk, p);
done:
    return status;
}

void stp_patch_levels_clear(stp_load_place *place)
{
    free(place->finest);
    free(place->view);
    place->finest = NULL;
    place->view = NULL;
}

static bool lacks(const stp_patch_look *look, const stp_resident *resident, int finest)
{
    const stp_gpu_chunk chunk = stp_scene_record(look->scene, resident->block, finest, look->eye);
    for (uint32_t p = 0; p < resident->placement.patches.count; p++) {
        const stp_mirror_patch *patch = &resident->mirror.patches[p];
        if (patch->finest > finest &&
            asked_in_sight(&look->frame, &chunk, patch, finest) < patch->finest &&
            !is_left(look, &chunk, resident, p))
            return true;
    }
    return false;
}

bool stp_patch_levels_lack(const stp_patch_look *look, stp_resident *resident, int finest)
{
    if (!resident->partial || resident->look == look->number)
        return false;
    const int asked = finest > resident->finest ? finest : resident->finest;
    const bool lack = lacks(look, resident, asked);
    if (!lack && asked == resident->finest)
        resident->look = look->number;
    return lack;
}

bool stp_patch_levels_shown(const stp_patch_look *look, const stp_resident *resident, uint8_t *out)
{
    stp_patch_look now = *look;
    const stp_gpu_chunk chunk =
        stp_scene_record(look->scene, resident->block, resident->finest, look->eye);
    bool fewer = false;
    now.ahead = false;
    for (uint32_t p = 0; p < resident->placement.patches.count; p++) {
        const stp_mirror_patch *patch = &resident->mirror.patches[p];
        out[p] = (uint8_t)(is_left(&now, &chunk, resident, p)
                               ? STP_LEVEL_COUNT - 1
                               : asked_in_sight(&look->frame, &chunk, patch, patch->finest));
        fewer = fewer || out[p] > patch->finest;
    }
    return fewer;
}

void stp_patch_levels_keep(stp_chunk *chunk, const uint8_t *finest)
{
    for (int l = chunk->finest_level; l < STP_LEVEL_COUNT - 1; l++) {
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
