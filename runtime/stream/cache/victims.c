/* The need of blocks, and a binary heap. */
#include "runtime/stream/cache/victims.h"

#include "runtime/cut/level_choice.h"

#include <math.h>
#include <stdbool.h>

float stp_need_of(const stp_scene *scene, uint32_t block, const stp_gpu_frame *frame, stp_dvec3 eye)
{
    const stp_block *b = &scene->blocks[block];
    stp_ball ball = stp_block_ball(b, stp_scene_entry(scene, block)->origin, eye);
    float f = frame->viewport[2], error = b->error[STP_LEVEL_COUNT - 1];
    float distance = (float)(stp_dvec3_length(ball.centre) - ball.radius);
    return frame->modes[0] != 0 ? error * f
                                : error * f / fmaxf(distance, fmaxf(frame->viewport[3], 1e-30f));
}

static bool comes_before(const stp_victim *a, const stp_victim *b)
{
    return a->need < b->need || (a->need == b->need && a->slot < b->slot);
}

static void sink(stp_victims *v, size_t at)
{
    for (size_t child; (child = 2 * at + 1) < v->count; at = child) {
        if (child + 1 < v->count && comes_before(&v->items[child + 1], &v->items[child]))
            child++;
        if (!comes_before(&v->items[child], &v->items[at]))
            return;
        stp_victim item = v->items[at];
        v->items[at] = v->items[child];
        v->items[child] = item;
    }
}

void stp_victims_sort(stp_victims *v)
{
    for (size_t at = v->count / 2; at-- > 0;)
        sink(v, at);
}

stp_victim stp_victims_take(stp_victims *v)
{
    stp_victim first = v->items[0];
    v->items[0] = v->items[--v->count];
    sink(v, 0);
    return first;
}
