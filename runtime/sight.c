/* Culls patches against children that are drawn, frustum and cone of normals. */
#include "runtime/sight.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

typedef struct look {
    stp_sight *sight;
    const stp_sight_params *params;
    const stp_draw *draws;
    size_t *found; /* of each draw */
} look;

/* Marks the tiles that a ball in eye space may cover. */
static void mark_tiles(const stp_sight_params *params, unsigned worker, const float eye[3],
                       float radius)
{
    const stp_gpu_frame *frame = params->frame;
    float f = frame->viewport[2], depth = -eye[2];
    float scale = f, reach = radius * f;
    if (frame->modes[0] == 0) {
        if (depth - radius <= frame->viewport[3]) {
            stp_tiles_mark_all(params->tiles, worker);
            return;
        }
        scale = f / depth;
        float x = eye[0] / depth, y = eye[1] / depth;
        reach *= sqrtf(1.0f + x * x + y * y) / (depth - radius);
    }
    stp_tiles_mark(params->tiles, worker, frame->centre[0] + eye[0] * scale,
                   frame->centre[1] + eye[1] * scale, reach);
}

/* Whether a bound, relative to the chunk's origin, is in sight; eye: gets its centre in eye space.
 */
static bool in_sight(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk, stp_rule_bound bound,
                     float eye[3])
{
    for (int axis = 0; axis < 3; axis++)
        bound.centre[axis] += chunk->offset[axis];
    return stp_rule_visible(frame, &bound, eye);
}

bool stp_patch_in_sight(const stp_gpu_frame *frame, const stp_draw *draw,
                        const stp_gpu_chunk *chunk, const stp_gpu_patch *patch)
{
    float eye[3];
    return !stp_patch_refined(draw, patch) && in_sight(frame, chunk, stp_patch_bound(patch), eye);
}

static stp_status look_at_draw(void *context, size_t index, unsigned worker, stp_error *err)
{
    (void)err;
    const look *l = context;
    const stp_sight_params *params = l->params;
    const stp_draw *draw = &l->draws[index];
    const stp_resident *r =
        stp_chunk_cache_get(params->cache, stp_chunk_cache_slot(params->cache, draw->chunk));
    stp_gpu_chunk chunk =
        stp_gpu_chunk_from_draw(&params->scene->entries[draw->chunk], draw, params->eye);
    uint32_t *out = l->sight->patches + l->sight->begin[index];
    size_t found = 0;
    for (uint32_t i = 0; i < r->placement.patches.count; i++) {
        float eye[3];
        if (stp_patch_refined(draw, &r->patches[i]) ||
            !in_sight(params->frame, &chunk, r->bounds[i], eye))
            continue;
        out[found++] = r->placement.patches.begin + i;
        mark_tiles(params, worker, eye, r->bounds[i].radius);
    }
    l->found[index] = found;
    return STP_OK;
}

/* Moves what was found together. */
static void close_gaps(stp_sight *s, const size_t *found, size_t count)
{
    size_t end = 0;
    for (size_t i = 0; i < count; i++) {
        memmove(s->patches + end, s->patches + s->begin[i], found[i] * sizeof *s->patches);
        s->begin[i] = end;
        end += found[i];
    }
    s->begin[count] = end;
}

stp_status stp_sight_look(stp_sight *s, const stp_sight_params *params, const stp_draw *draws,
                          size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    size_t *found = NULL, most = 0;
    STP_TRY(stp_alloc(&found, count + 1, sizeof *found, "a list of patches", err));
    STP_TRY(stp_grow(&s->begin, &s->begin_capacity, count + 1, sizeof *s->begin,
                     "a list of patches", err));
    for (size_t i = 0; i < count; i++) {
        s->begin[i] = most;
        most += params->scene->entries[draws[i].chunk].patch_count;
    }
    STP_TRY(stp_grow(&s->patches, &s->patch_capacity, most + 1, sizeof *s->patches,
                     "a list of patches", err));
    look l = {s, params, draws, found};
    STP_TRY(stp_pool_run(params->pool, count, look_at_draw, &l, err));
    close_gaps(s, found, count);
done:
    free(found);
    return status;
}

void stp_sight_destroy(stp_sight *s)
{
    free(s->patches);
    free(s->begin);
    *s = (stp_sight){0};
}
