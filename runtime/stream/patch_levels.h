/* Which levels of a block are resident, patch by patch. A block is read as far as its neediest
 * patch asks, which for most of its patches is too far: their finer samples are left out on the
 * GPU. Threads: any (pure functions). */
#ifndef STP_RUNTIME_STREAM_PATCH_LEVELS_H
#define STP_RUNTIME_STREAM_PATCH_LEVELS_H

#include "runtime/stream/block_cache.h"

/* Chooses the finest level of each patch of a wanted block: the one that the view asks for, or will
 * ask for when it is somewhat nearer, be the patch in sight or not, but none finer than is wanted;
 * all patches have level STP_NEED_HEADERS. resident: the block as it is there, NULL if it is not.
 * sample_count gets the samples of each level. *out stays NULL if all patches get what is wanted;
 * else the caller frees it. Errors: OUT_OF_MEMORY. */
stp_status stp_patch_levels_choose(uint8_t **out, uint32_t sample_count[STP_LEVEL_COUNT],
                                   const stp_scene *scene, const stp_gpu_frame *frame,
                                   stp_dvec3 eye, const stp_want *want,
                                   const stp_resident *resident, stp_error *err);
/* Whether the view asks some patch for a level, not finer than `finest`, that is not resident. */
bool stp_patch_levels_lack(const stp_scene *scene, const stp_gpu_frame *frame, stp_dvec3 eye,
                           const stp_resident *resident, int finest);
/* Leaves out the samples of each patch of a decoded block that are finer than its level in the
 * list. */
void stp_patch_levels_keep(stp_chunk *chunk, const uint8_t *finest);

#endif
