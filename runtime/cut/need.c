/* Asks all patches of a block for their levels. */
#include "runtime/cut/need.h"

#include "runtime/cut/culling.h"

int stp_block_need(const stp_scene *scene, const stp_gpu_frame *frame, stp_dvec3 eye,
                   const stp_occlusion *occlusion, const stp_resident *resident, int estimate)
{
    const stp_gpu_chunk chunk = stp_scene_record(scene, resident->block, estimate, eye);
    int need = STP_NEED_HEADERS;
    stp_gpu_frame room;
    frame = stp_culling_narrow(&room, frame, scene, resident->block, eye, NULL);
    for (uint32_t i = 0; i < resident->placement.patches.count && need > estimate; i++) {
        const stp_rule_bound bound = stp_patch_bound(&resident->mirror.briefs[i], &chunk);
        float centre[3];
        if (!stp_rule_visible(frame, &bound, centre) ||
            stp_occlusion_hides(occlusion, bound.centre, bound.radius))
            continue;
        const stp_levels levels = stp_levels_choose(frame, &chunk, &resident->mirror.patches[i]);
        for (int q = 0; q < STP_PATCH_QUARTERS; q++)
            if (levels.of[q] != STP_LEVEL_SKIP && levels.of[q] < need)
                need = levels.of[q];
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
