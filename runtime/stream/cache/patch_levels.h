/* Which levels of a block are resident, patch by patch. A block is read as far as its neediest
 * patch asks. For most patches that is too far, so their finer samples are left out on the GPU;
 * many patches keep only the vertex. Threads: any (pure functions). */
#ifndef STP_RUNTIME_STREAM_CACHE_PATCH_LEVELS_H
#define STP_RUNTIME_STREAM_CACHE_PATCH_LEVELS_H

#include "runtime/cut/need.h"

/* Where blocks are seen from. */
typedef struct stp_patch_look {
    const stp_scene *scene;
    stp_gpu_frame frame;
    stp_dvec3 eye;
    uint32_t number;
    bool ahead;                  /* other views follow */
    const stp_need_below *below; /* NULL: no patch is left to a block below */
} stp_patch_look;

/* Chooses the finest level of each patch of a wanted block, none finer than is wanted: the one that
 * the view asks for if the patch is in sight, and not left to a block below. ahead: it is the one
 * that the view will ask for when it is somewhat nearer, be the patch in sight or not. resident:
 * the block as it is there. If it is NULL, only the view is set: the levels are chosen when the
 * patches are decoded. sample_count gets the most samples of each level. out->finest stays NULL if
 * all patches get what is wanted. Errors: OUT_OF_MEMORY. */
stp_status stp_patch_levels_choose(stp_load_place *out, uint32_t sample_count[STP_LEVEL_COUNT],
                                   const stp_patch_look *look, const stp_want *want,
                                   const stp_resident *resident, stp_error *err);
/* Leaves out the samples of a decoded block that are finer than its patches' levels, which are
 * chosen now if they were not. patches: of the block. Errors: OUT_OF_MEMORY. */
stp_status stp_patch_levels_leave(stp_load_place *place, stp_mirror_patch *patches,
                                  stp_chunk *chunk, stp_error *err);
/* Frees what was chosen. */
void stp_patch_levels_clear(stp_load_place *place);
/* Whether the view asks some patch for a level, not finer than `finest`, that is not resident.
 * Notes in resident->look that it does not. */
bool stp_patch_levels_lack(const stp_patch_look *look, stp_resident *resident, int finest);
/* Lists the finest levels that the view asks for of a block's patches, as if no other view
 * followed, and none finer than what is resident. Returns whether any patch has a finer one. */
bool stp_patch_levels_shown(const stp_patch_look *look, const stp_resident *resident, uint8_t *out);
/* Leaves out the samples of each patch of a decoded block that are finer than its level in the
 * list. */
void stp_patch_levels_keep(stp_chunk *chunk, const uint8_t *finest);

#endif
