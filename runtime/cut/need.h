/* The finest level that a view asks of a block, told by its patches. The table of blocks knows only
 * the worst of all patches, seen from the worst side; one patch at an outline would fetch level 0
 * of all. So a block is first read to level 2, with the headers of its patches, and then only as
 * far as one of them asks. Threads: any (pure functions). */
#ifndef STP_RUNTIME_CUT_NEED_H
#define STP_RUNTIME_CUT_NEED_H

#include "runtime/cut/occlusion.h"
#include "runtime/cut/scene.h"
#include "runtime/stream/cache/block_cache.h"

/* A block is read to this level before its patches are known. */
#define STP_NEED_HEADERS 2

/* While a block is on its way, the patches above that are left to it ask for this level: it costs
 * little, so that first all of the picture gets finer. */
#define STP_NEED_MEANWHILE 1

/* The finest level that a patch above a block may ask for if it is left to that block: 0 if the
 * block is not drawn and will not be, STP_NEED_HEADERS (which is there) if it is or will be. */
typedef struct stp_need_below {
    int (*level)(const void *context, uint32_t block);
    const void *context;
} stp_need_below;

/* Fetches the memory of a resident block that is looked at after the next one, or, `next`, of the
 * briefs of the next one. Blocks lie apart in memory: waiting for it was most of a look's time. */
void stp_block_prefetch(const stp_resident *resident, bool next);

/* The finest level that a patch in sight of a resident block is drawn at. Patches that `occlusion`
 * hides are not in sight. In a linked chunk, patches of which no level does are left to the block
 * below, and ask for no more than `below` says. estimate: the answer by the table,
 * which is never coarser than the patches ask for. *lacks: a patch asks for a level that is not
 * resident of this patch, though it may be of others. */
int stp_block_need(const stp_scene *scene, const stp_gpu_frame *frame, stp_dvec3 eye,
                   const stp_occlusion *occlusion, const stp_resident *resident, int estimate,
                   const stp_need_below *below, bool *lacks);

/* Tells which blocks below a resident block need be drawn: calls `refer` for each of its patches in
 * sight that has a block below. coarse: no level of the patch does. */
void stp_block_refer(const stp_scene *scene, const stp_gpu_frame *frame, stp_dvec3 eye,
                     const stp_occlusion *occlusion, const stp_resident *resident,
                     void (*refer)(void *context, uint32_t below, bool coarse), void *context);

#endif
