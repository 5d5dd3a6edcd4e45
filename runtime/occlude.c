/* Leaves out what a picture hides ("Occlusion" in shaders/README.md). A picture is drawn without
 * what the last one hides. If the new one hides all of that, too, it is the picture that it would
 * be without occlusion, byte for byte. Otherwise a view at rest, or a picture that waits, is drawn
 * once more, without what the new one hides. */
#include "runtime/occlude.h"

#include "runtime/renderer_parts.h"

#include <stdatomic.h>

/* So many pixels around a bound must hide, too: as far as its tiles reach (runtime/cut/tiles.c),
 * which is farther than smooth edges look. */
#define REST_MARGIN_PX 6.0f
/* And more if the camera has moved: as far as its motion brings to light what lies behind an
 * outline. Beyond the limit, and if the last picture lacked more than a share of its blocks,
 * nothing that is resident is left out. */
#define MOTION_MARGIN_LEAST_PX 8.0f
#define MOTION_MARGIN_MOST_PX 64.0f
#define MISSING_SHARE 0.05
/* After so many pictures that brought something to light, nothing is left out. */
#define ROUNDS_LIMIT 5
/* If fewer blocks are missing, they are read without a guess what is hidden. */
#define GUESS_LEAST 32
#define GUESSES_LIMIT 4
/* If less than this share of all patches and blocks is hidden while the camera moves, so many
 * pictures go without. At rest, what is hidden need not be resident: without occlusion, the next
 * picture would draw it too coarse, and show some of it. */
#define LEAST_SHARE 0.1
#define IDLE_PICTURES 30

/* Whether pictures with these parameters are closed by pull and push, and all that is drawn of a
 * patch lies in its bound. */
static bool can_occlude(const stp_renderer *r, const stp_draw_params *params)
{
    const bool exaggerated = params->exaggerate > 0.0 && params->exaggerate != 1.0;
    bool asked = params->occlusion == STP_OCCLUSION_ON ||
                 (params->occlusion == STP_OCCLUSION_AUTO && params->stream);
    return asked && params->reconstruct <= STP_RECONSTRUCT_BOX &&
           stp_scene_shapes(&r->scene) == 0 && !exaggerated && !r->occluding.squares;
}

/* Whether the last picture shows what this one is to show, from wherever. */
static bool shows_the_same(const stp_renderer *r, const stp_draw_params *params)
{
    stp_draw_params like = *params;
    like.lod = r->drawn.lod;
    like.threshold_px = r->drawn.threshold_px;
    like.stream = r->drawn.stream;
    return stp_draw_params_equal(&like, &r->drawn);
}

/* Takes what the GPU found out about the last picture, if it has. */
static stp_status take(stp_renderer *r, bool waits, stp_error *err)
{
    stp_occluding *o = &r->occluding;
    bool taken = false;
    stp_status status = stp_far_depths_take(&o->depths, waits, &o->maps[!o->newest], &taken, err);
    if (taken) {
        o->newest = !o->newest;
        o->known = true;
    }
    return status;
}

/* Chooses what the next picture leaves out. */
void stp_occlude_choose(stp_renderer *r, bool streams)
{
    stp_occluding *o = &r->occluding;
    stp_occlusion *map = &o->maps[o->newest];
    o->used = NULL;
    if (!o->on || !o->known || o->rounds >= ROUNDS_LIMIT)
        return;
    const bool same = stp_occlusion_is_of(map, &r->frame, r->eye);
    const float more =
        same ? 0.0f : fmaxf(MOTION_MARGIN_LEAST_PX, stp_occlusion_parallax(map, r->eye));
    stp_occlusion_aim(map, r->eye, REST_MARGIN_PX + fminf(more, MOTION_MARGIN_MOST_PX), same);
    map->asks_only = streams && (o->coarse || more > MOTION_MARGIN_MOST_PX);
    o->used = map;
}

stp_status stp_occlude_begin(stp_renderer *r, const stp_draw_params *params, stp_error *err)
{
    stp_occluding *o = &r->occluding;
    stp_status status = take(r, false, err);
    if (!r->still || !params->stream || stp_block_cache_has_news(r->cache))
        o->rounds = 0;
    o->on = can_occlude(r, params) && o->idle == 0;
    o->known = o->known && o->on && shows_the_same(r, params);
    o->idle -= o->idle > 0;
    stp_occlude_choose(r, params->stream);
    o->guesses = 0;
    return status;
}

bool stp_occlude_wants_guess(stp_renderer *r)
{
    stp_occluding *o = &r->occluding;
    return o->on && r->cut.miss_count >= GUESS_LEAST && o->guesses++ < GUESSES_LIMIT;
}

stp_status stp_occlude_guessed(stp_renderer *r, stp_error *err)
{
    stp_status status = take(r, true, err);
    stp_occlude_choose(r, false);
    return status;
}

const stp_occlusion *stp_occlude_drawn(const stp_renderer *r)
{
    const stp_occlusion *used = r->occluding.used;
    return used != NULL && !used->asks_only ? used : NULL;
}

void stp_occlude_count(stp_renderer *r, stp_drawing *d, size_t draw_count)
{
    if (d->stats.passes == 0)
        r->occluding.shown = 0;
    for (int i = STP_SIGHT_PATCHES; i <= STP_SIGHT_QUARTERS; i++)
        r->occluding.shown += r->sight.lists[i].begin[draw_count];
    d->stats.patches_hidden += r->sight.hidden;
}

void stp_occlude_pause(stp_renderer *r)
{
    r->occluding.on = false;
    r->occluding.used = NULL;
}

void stp_occlude_forget(stp_renderer *r)
{
    stp_far_depths_forget(&r->occluding.depths);
    r->occluding.known = r->occluding.squares = false;
    stp_occlude_pause(r);
}

void stp_occlude_destroy(stp_renderer *r)
{
    stp_far_depths_destroy(&r->occluding.depths);
    stp_occlusion_destroy(&r->occluding.maps[0]);
    stp_occlusion_destroy(&r->occluding.maps[1]);
}

stp_status stp_occlude_look(stp_renderer *r, int levels, stp_error *err)
{
    if (!r->occluding.on || r->occluding.depths.fence != NULL) /* a picture is on its way */
        return STP_OK;
    return stp_far_depths_begin(&r->occluding.depths, &r->pyramid, levels, &r->frame, r->eye,
                                &r->variant, r->shader_folder, err);
}

/* What the threads that search need. */
typedef struct search {
    const stp_renderer *r;
    const stp_occlusion *now;
    atomic_bool exposed;
} search;

static const stp_resident *resident_of(const stp_renderer *r, uint32_t block)
{
    return stp_block_cache_finest(r->cache, block) == STP_NOT_RESIDENT
               ? NULL
               : stp_block_cache_get(r->cache, stp_block_cache_slot(r->cache, block));
}

/* Searches a block that was drawn or passed for patches that were left out and come to light. */
static stp_status search_block(void *context, size_t index, unsigned worker, stp_error *err)
{
    search *s = context;
    const stp_renderer *r = s->r;
    const stp_cut *cut = &r->cut;
    const uint32_t block =
        index < cut->draw_count ? cut->draws[index].block : cut->passed[index - cut->draw_count];
    const stp_resident *resident = resident_of(r, block);
    const stp_gpu_chunk chunk = stp_scene_record(&r->scene, block, 0, r->eye);
    (void)worker;
    (void)err;
    for (uint32_t i = 0; resident != NULL && i < resident->placement.patches.count; i++) {
        const stp_rule_bound b = stp_patch_bound(&resident->mirror.briefs[i], &chunk);
        float eye[3];
        if (atomic_load_explicit(&s->exposed, memory_order_relaxed))
            break;
        if (stp_occlusion_hides(r->occluding.used, b.centre, b.radius) &&
            !stp_occlusion_hides(s->now, b.centre, b.radius) &&
            stp_rule_visible(&r->frame, &b, eye))
            atomic_store_explicit(&s->exposed, true, memory_order_relaxed);
    }
    return STP_OK;
}

/* Whether the newest picture fails to hide something that was left out of it. */
static stp_status exposes(stp_renderer *r, bool *out, stp_error *err)
{
    stp_occluding *o = &r->occluding;
    stp_occlusion *now = &o->maps[o->newest];
    search s = {.r = r, .now = now};
    *out = false;
    if (o->used == NULL)
        return STP_OK;
    if (o->used->asks_only) { /* blocks may come to light once those on their way are there */
        *out = r->cut.miss_count == 0;
        return STP_OK;
    }
    if (!stp_occlusion_is_of(now, &r->frame, r->eye)) { /* an earlier picture was on its way */
        *out = true;
        return STP_OK;
    }
    stp_occlusion_aim(now, r->eye, REST_MARGIN_PX, true);
    for (size_t i = 0; i < r->cut.occluded_count; i++)
        if (!stp_occlusion_hides_box(now, &r->cut.occluded[i])) {
            *out = true;
            return STP_OK;
        }
    stp_status status =
        stp_pool_run(r->pool, r->cut.draw_count + r->cut.passed_count, search_block, &s, err);
    *out = atomic_load(&s.exposed);
    return status;
}

/* Squares of grids are drawn as triangles that reach beyond their bounds. */
static void note_squares(stp_renderer *r)
{
    for (size_t i = 0; i < r->cut.draw_count && !r->occluding.squares; i++) {
        const stp_resident *resident = resident_of(r, r->cut.draws[i].block);
        r->occluding.squares = resident != NULL && resident->mirror.squares != NULL;
    }
}

stp_status stp_occlude_end(stp_renderer *r, stp_drawing *d, stp_error *err)
{
    stp_occluding *o = &r->occluding;
    stp_status status = STP_OK;
    d->stats.exposes = false;
    if (!o->on)
        return STP_OK;
    o->coarse = (double)r->cut.miss_count > MISSING_SHARE * (double)r->cut.draw_count;
    note_squares(r);
    STP_TRY(take(r, d->waits || r->still || !d->params->stream, err));
    if (o->used != NULL) {
        d->stats.blocks_hidden = (uint32_t)r->cut.occluded_count;
        const uint64_t hidden = d->stats.patches_hidden + d->stats.blocks_hidden;
        if (d->params->occlusion == STP_OCCLUSION_AUTO && !o->used->asks_only && !r->still &&
            (double)hidden < LEAST_SHARE * (double)(hidden + o->shown))
            o->idle = IDLE_PICTURES;
    }
    if (r->still || !d->params->stream)
        STP_TRY(exposes(r, &d->stats.exposes, err));
    o->rounds += d->stats.exposes;
done:
    return status;
}
