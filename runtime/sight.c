/* Culls patches against children that are drawn, frustum and cone of normals. */
#include "runtime/sight.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

typedef struct look {
    stp_sight *sight;
    const stp_sight_params *params;
    const stp_draw *draws;
    size_t *patches, *vertices; /* found of each draw */
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

bool stp_patch_in_sight(const stp_gpu_frame *frame, const stp_draw *draw,
                        const stp_gpu_chunk *chunk, const stp_gpu_patch *patch)
{
    float eye[3];
    stp_patch_brief brief = stp_patch_brief_of(patch);
    stp_rule_bound bound = stp_patch_bound(&brief, chunk);
    return !stp_patch_refined(draw, patch) && stp_rule_visible(frame, &bound, eye);
}

static bool vertex_does(const stp_gpu_frame *frame, const stp_rule_bound *bound,
                        const stp_patch_brief *brief)
{
    stp_rule_sight sight = stp_rule_look(frame, bound);
    return stp_vertex_does(frame, &sight, brief->vertex_error, brief->vertex_radius);
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
    uint32_t *patches = l->sight->patches.items + l->sight->patches.begin[index];
    uint32_t *vertices = l->sight->vertices.items + l->sight->vertices.begin[index];
    size_t patch_count = 0, vertex_count = 0;
    for (uint32_t i = 0; i < r->placement.patches.count; i++) {
        float eye[3];
        const stp_patch_brief *brief = &r->briefs[i];
        stp_rule_bound bound = stp_patch_bound(brief, &chunk);
        if (stp_patch_refined(draw, &r->patches[i]) ||
            !stp_rule_visible(params->frame, &bound, eye))
            continue;
        mark_tiles(params, worker, eye, bound.radius);
        if (params->vertices && vertex_does(params->frame, &bound, brief))
            vertices[vertex_count++] = r->placement.level_begin[STP_LEVEL_COUNT - 1] + i;
        else
            patches[patch_count++] = r->placement.patches.begin + i;
    }
    l->patches[index] = patch_count;
    l->vertices[index] = vertex_count;
    return STP_OK;
}

/* Makes room for what each draw may have at most. */
static stp_status reserve(stp_sight_list *list, const stp_sight_params *params,
                          const stp_draw *draws, size_t count, bool used, stp_error *err)
{
    stp_status status = STP_OK;
    size_t most = 0;
    STP_TRY(stp_grow(&list->begin, &list->begin_capacity, count + 1, sizeof *list->begin,
                     "a list of patches", err));
    for (size_t i = 0; i < count; i++) {
        list->begin[i] = most;
        most += used ? params->scene->entries[draws[i].chunk].patch_count : 0;
    }
    STP_TRY(stp_grow(&list->items, &list->item_capacity, most + 1, sizeof *list->items,
                     "a list of patches", err));
done:
    return status;
}

/* Moves what was found together. */
static void close_gaps(stp_sight_list *list, const size_t *found, size_t count)
{
    size_t end = 0;
    for (size_t i = 0; i < count; i++) {
        memmove(list->items + end, list->items + list->begin[i], found[i] * sizeof *list->items);
        list->begin[i] = end;
        end += found[i];
    }
    list->begin[count] = end;
}

stp_status stp_sight_look(stp_sight *s, const stp_sight_params *params, const stp_draw *draws,
                          size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    size_t *found = NULL;
    STP_TRY(stp_alloc(&found, 2 * count + 1, sizeof *found, "a list of patches", err));
    STP_TRY(reserve(&s->patches, params, draws, count, true, err));
    STP_TRY(reserve(&s->vertices, params, draws, count, params->vertices, err));
    look l = {s, params, draws, found, found + count};
    STP_TRY(stp_pool_run(params->pool, count, look_at_draw, &l, err));
    close_gaps(&s->patches, l.patches, count);
    close_gaps(&s->vertices, l.vertices, count);
done:
    free(found);
    return status;
}

void stp_sight_destroy(stp_sight *s)
{
    free(s->patches.items);
    free(s->patches.begin);
    free(s->vertices.items);
    free(s->vertices.begin);
    *s = (stp_sight){0};
}
