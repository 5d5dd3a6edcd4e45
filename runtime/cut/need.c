/* Asks all patches of a block for their levels. */
#include "runtime/cut/need.h"

#include "runtime/cut/culling.h"

/* The finest level that a patch in sight may ask for. It is left to the block below if even its
 * level 0 is too coarse. */
static int finest_of(const stp_gpu_frame *frame, const stp_resident *resident, uint32_t patch,
                     const stp_rule_bound *bound, const stp_need_below *below)
{
    const uint32_t block = resident->mirror.briefs[patch].block;
    const stp_rule_sight sight = stp_rule_look(frame, bound);
    if (block == STP_BLOCK_NONE ||
        stp_finest_does(frame, &sight, &resident->mirror.patches[patch], 0))
        return 0;
    return below->level(below->context, block);
}

int stp_block_need(const stp_scene *scene, const stp_gpu_frame *frame, stp_dvec3 eye,
                   const stp_occlusion *occlusion, const stp_resident *resident, int estimate,
                   const stp_need_below *below, bool *lacks)
{
    const stp_gpu_chunk chunk = stp_scene_record(scene, resident->block, estimate, eye);
    const bool linked = (stp_scene_entry(scene, resident->block)->flags & STP_CHUNK_LINKED) != 0;
    int need = STP_NEED_HEADERS;
    stp_gpu_frame room;
    *lacks = false;
    frame = stp_culling_narrow(&room, frame, scene, resident->block, eye, NULL);
    for (uint32_t i = 0; i < resident->placement.patches.count; i++) {
        const stp_mirror_patch *patch = &resident->mirror.patches[i];
        if (need <= estimate && patch->finest <= estimate)
            continue;
        const stp_rule_bound bound = stp_patch_bound(&resident->mirror.briefs[i], &chunk);
        float centre[3];
        if (!stp_rule_visible(frame, &bound, centre) ||
            stp_occlusion_hides(occlusion, bound.centre, bound.radius))
            continue;
        const int finest = linked ? finest_of(frame, resident, i, &bound, below) : 0;
        if (finest >= STP_NEED_HEADERS)
            continue;
        const int asked =
            stp_level_asked(frame, &chunk, patch, finest > estimate ? finest : estimate);
        need = asked < need ? asked : need;
        *lacks |= asked < patch->finest;
    }
    return need;
}

void stp_block_refer(const stp_scene *scene, const stp_gpu_frame *frame, stp_dvec3 eye,
                     const stp_occlusion *occlusion, const stp_resident *resident,
                     void (*refer)(void *context, uint32_t below, bool coarse), void *context)
{
    const stp_gpu_chunk chunk = stp_scene_record(scene, resident->block, 0, eye);
    stp_gpu_frame room;
    frame = stp_culling_narrow(&room, frame, scene, resident->block, eye, NULL);
    for (uint32_t i = 0; i < resident->placement.patches.count; i++) {
        const stp_patch_brief *brief = &resident->mirror.briefs[i];
        const stp_rule_bound bound = stp_patch_bound(brief, &chunk);
        float centre[3];
        if (brief->block == STP_BLOCK_NONE || !stp_rule_visible(frame, &bound, centre))
            continue;
        const bool hidden = stp_occlusion_hides(occlusion, bound.centre, bound.radius);
        if (hidden && !occlusion->asks_only)
            continue;
        const stp_rule_sight sight = stp_rule_look(frame, &bound);
        refer(context, brief->block,
              !hidden && !stp_finest_does(frame, &sight, &resident->mirror.patches[i], 0));
    }
}
