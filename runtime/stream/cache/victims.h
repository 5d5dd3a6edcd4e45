/* Who leaves next: slots in a heap, the least needed first. Threads: the render thread. */
#ifndef STP_RUNTIME_STREAM_CACHE_VICTIMS_H
#define STP_RUNTIME_STREAM_CACHE_VICTIMS_H

#include "runtime/cut/scene.h"
#include "runtime/gl/gpu_layout.h"

#include <stddef.h>
#include <stdint.h>

/* Pixels of error that the parent would show, if the block faced the eye and lay in front of it. */
float stp_need_of(const stp_scene *scene, uint32_t block, const stp_gpu_frame *frame,
                  stp_dvec3 eye);

typedef struct stp_victim {
    float need;
    uint32_t slot, block;
} stp_victim;

/* `items` has room for all slots; the caller fills items[0..count), then sorts. */
typedef struct stp_victims {
    stp_victim *items;
    size_t count;
} stp_victims;

/* Makes a heap of the items. */
void stp_victims_sort(stp_victims *victims);
/* Takes the first item out, which must exist: the least need, then the least slot. */
stp_victim stp_victims_take(stp_victims *victims);

#endif
