/* Lets tests and measurements look inside a renderer after a frame; not for host applications. */
#ifndef STP_RUNTIME_INSPECT_H
#define STP_RUNTIME_INSPECT_H

#include "runtime/cut/cut.h"
#include "runtime/cut/model.h"
#include "runtime/cut/sight.h"
#include "runtime/draw/pyramid.h"
#include "runtime/stipple.h"
#include "runtime/stream/cache/block_cache.h"

/* Borrowed from the renderer; valid until the renderer's next call. */
typedef struct stp_inspection {
    const stp_pyramid *pyramid;
    const stp_cut *cut;
    const stp_sight *sight;
    bool kept;               /* cut and sight are those of the frame before */
    stp_sight_params looked; /* how the sight was looked at, as far as queries need it */
    const stp_block_cache *cache;
    const stp_gpu_frame *frame;
    stp_dvec3 eye;
} stp_inspection;

stp_inspection stp_renderer_inspect(const stp_renderer *renderer);

#endif
