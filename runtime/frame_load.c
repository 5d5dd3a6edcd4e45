/* What a frame draws and asks for: describes the view, chooses the cut by what is resident, and
 * loads blocks, first their headers, then as far as their patches ask. */
#include "runtime/frame_load.h"

#include "base/clock.h"
#include "base/memory.h"
#include "runtime/colour_range.h"
#include "runtime/cut/culling.h"
#include "runtime/cut/need.h"
#include "runtime/draw/filter.h"
#include "runtime/frame_pass.h"
#include "runtime/frame_ready.h"
#include "runtime/occlude.h"
#include "runtime/renderer_parts.h"

/* Requests at most so many blocks ahead of the camera's motion. */
#define AHEAD_LIMIT 512

/* Whether the picture shows the samples' own colours, or how a picture that does chooses levels. */
static bool shows_colours(const stp_draw_params *params)
{
    bool plain = params->shade == STP_SHADE_NORMAL || params->shade == STP_SHADE_DEPTH;
    return params->colour == STP_COLOUR_RGB && !plain;
}

stp_gpu_frame stp_frame_describe(const stp_view *view, const stp_draw_params *params,
                                 const stp_scene *scene)
{
    stp_gpu_frame frame = stp_gpu_frame_from_view(view);
    const stp_dvec3 eye = stp_unexaggerated(params, view->eye);
    bool every = params->every_sample || params->lod == STP_LOD_FULL;
    double threshold = params->threshold_px > 0.0 ? params->threshold_px : 1.0;
    double cap = params->radius_cap_px > 0.0  ? params->radius_cap_px
                 : stp_scene_is_chosen(scene) ? STP_RADIUS_CAP_CHOSEN_PX
                                              : STP_RADIUS_CAP_PX;
    uint32_t terms = params->terms != 0 ? params->terms : STP_TERMS_DEFAULT;
    bool colour = (terms & STP_TERM_COLOUR) != 0 && shows_colours(params);
    frame.quality[0] = every ? 0.0f : (float)threshold;
    frame.quality[1] =
        terms & STP_TERM_RADIUS ? (float)(cap * fmax(1.0, threshold * threshold)) : INFINITY;
    frame.terms[0] = colour ? STP_COLOUR_WEIGHT : 0.0f;
    frame.terms[1] = terms & STP_TERM_SILHOUETTE ? STP_SILHOUETTE_WEIGHT : 1.0f;
    if (params->exaggerate > 0.0 && params->exaggerate != 1.0)
        stp_gpu_frame_exaggerate(&frame, params->exaggerate);
    stp_culling_place(&frame, params, view, scene);
    stp_colour_range_place(frame.colour_range, params, &eye);
    stp_filter_place(&frame, params, &eye);
    return frame;
}

/* A round loads a tier of the tree or a finer level. More rounds than this would mean that blocks
 * push each other out: then the picture takes passes. */
#define ASKED_ROUNDS_LIMIT 1000

/* A view that a cut is chosen for: the frame's own, or the one ahead. */
typedef struct cut_view {
    const stp_renderer *renderer;
    const stp_gpu_frame *frame;
    stp_dvec3 eye;
    const stp_occlusion *occlusion; /* may be NULL */
    const stp_cut *chosen;          /* NULL while the cut is being chosen */
    bool streams;                   /* the picture shows what is there */
} cut_view;

/* For frames that wait for the cut: every block that is not damaged will be resident. */
static int available_soon(const void *context, uint32_t block)
{
    const stp_block_cache *cache = ((const cut_view *)context)->renderer->cache;
    return stp_block_cache_damaged(cache, block) ? STP_CUT_NEVER : 0;
}

static int available_now(const void *context, uint32_t block)
{
    const stp_block_cache *cache = ((const cut_view *)context)->renderer->cache;
    return stp_block_cache_damaged(cache, block) ? STP_CUT_NEVER
                                                 : stp_block_cache_finest(cache, block);
}

static const stp_resident *resident_now(const void *context, uint32_t block)
{
    const stp_block_cache *cache = ((const cut_view *)context)->renderer->cache;
    return stp_block_cache_finest(cache, block) == STP_NOT_RESIDENT
               ? NULL
               : stp_block_cache_get(cache, stp_block_cache_slot(cache, block));
}

/* As stp_need_below.level. While the cut is being chosen, a block below is drawn if it can be,
 * since then the patches that ask for it are resident. */
static int level_above(const void *context, uint32_t block)
{
    const cut_view *v = context;
    const stp_block_cache *cache = v->renderer->cache;
    if (v->chosen != NULL ? v->chosen->blocks[block].state == STP_CUT_LEFT
                          : stp_block_cache_damaged(cache, block))
        return 0;
    return v->streams && stp_block_cache_finest(cache, block) == STP_NOT_RESIDENT
               ? STP_NEED_MEANWHILE
               : STP_NEED_HEADERS;
}

/* Patches that are resident tell exactly what they need. Those of other blocks are read first. */
static int needed_now(const void *context, uint32_t block, int estimate, bool *lacks)
{
    const cut_view *v = context;
    const stp_resident *resident = resident_now(context, block);
    if (v->frame->quality[0] <= 0.0f ||
        (resident != NULL && resident->finest <= estimate && !resident->partial)) {
        *lacks = resident != NULL && resident->partial;
        return estimate;
    }
    if (resident == NULL)
        return estimate > STP_NEED_HEADERS ? estimate : STP_NEED_HEADERS;
    return stp_block_need(&v->renderer->scene, v->frame, v->eye, v->occlusion, resident, estimate,
                          &(stp_need_below){level_above, v}, lacks);
}

static void prefetch(const void *context, uint32_t block, bool next)
{
    const stp_block_cache *cache = ((const cut_view *)context)->renderer->cache;
    const uint32_t slot = stp_block_cache_slot(cache, block);
    if (slot != STP_SLOT_NONE)
        stp_block_prefetch(stp_block_cache_get(cache, slot), next);
}

static bool was_drawn(const void *context, uint32_t block)
{
    const stp_renderer *r = ((const cut_view *)context)->renderer;
    return stp_block_cache_used(r->cache, block, r->drawn_stamp);
}

bool stp_frame_may_keep(const stp_renderer *r)
{
    return r->still && r->occluding.used == NULL &&
           r->looked_state == stp_block_cache_state(r->cache);
}

/* now: of what is resident; else as if everything were. */
static stp_status select_for(stp_renderer *r, const stp_drawing *d, stp_cut *cut,
                             const cut_view *view, bool now, stp_error *err)
{
    if (cut == &r->cut) {
        r->keeps = false;
        r->chosen_state = r->looked_state = 0;
    }
    stp_cut_params params = {
        .scene = &r->scene,
        .frame = view->frame,
        .eye = view->eye,
        .source = {view, now ? available_now : available_soon, now ? needed_now : NULL,
                   resident_now, d->params->stream && r->moves ? was_drawn : NULL,
                   now ? prefetch : NULL},
        .hidden_models = d->params->hidden_models,
        .occlusion = view->occlusion,
        .pool = r->pool,
    };
    return stp_cut_select(cut, &params, err);
}

stp_status stp_frame_select(stp_renderer *r, const stp_drawing *d, stp_error *err)
{
    const cut_view view = {r, &r->frame, r->eye, r->occluding.used, NULL, d->params->stream};
    stp_status status = select_for(r, d, &r->cut, &view, d->params->stream, err);
    return status == STP_OK ? stp_sight_begin(&r->sight, &r->cut, err) : status;
}

stp_status stp_frame_list_wants(stp_renderer *r, const stp_draw *draws, size_t count, bool headers,
                                stp_error *err)
{
    const int coarsest = headers ? STP_NEED_HEADERS : 0;
    stp_status status =
        stp_grow(&r->wants, &r->want_capacity, count, sizeof *r->wants, "a list of blocks", err);
    for (size_t i = 0; status == STP_OK && i < count; i++)
        r->wants[i] =
            (stp_want){draws[i].block, draws[i].finest > coarsest ? draws[i].finest : coarsest};
    return status;
}

/* What refine_one needs. */
typedef struct needs {
    cut_view view;
    stp_draw *draws;
} needs;

static stp_status refine_one(void *context, size_t index, unsigned worker, stp_error *err)
{
    const needs *n = context;
    stp_draw *draw = &n->draws[index];
    (void)worker;
    (void)err;
    bool lacks = false; /* loading finds it out */
    draw->finest = needed_now(&n->view, draw->block, draw->finest, &lacks);
    return STP_OK;
}

bool stp_frame_asks_headers(const stp_renderer *r)
{
    return r->frame.quality[0] > 0.0f;
}

stp_status stp_frame_refine(stp_renderer *r, stp_draw *draws, size_t count, stp_error *err)
{
    return stp_pool_run(r->pool, count, refine_one,
                        &(needs){{r, &r->frame, r->eye, r->occluding.used, &r->cut, false}, draws},
                        err);
}

/* Loads draws, as many as there is room for. */
static stp_status load_round(stp_renderer *r, const stp_draw *draws, size_t count, bool headers,
                             stp_cache_load *load, stp_error *err)
{
    stp_status status = stp_frame_list_wants(r, draws, count, headers, err);
    if (status != STP_OK)
        return status;
    *load = (stp_cache_load){.wants = r->wants, .count = count, .stamp = ++r->stamp};
    return stp_block_cache_load(r->cache, load, err);
}

/* Loads the cut's draws from draw `begin` on: unless their levels are known, first what tells them;
 * then the levels. */
stp_status stp_frame_load_draws(stp_renderer *r, stp_drawing *d, size_t begin, bool known,
                                stp_cache_load *load, stp_error *err)
{
    stp_status status = STP_OK;
    double begun = stp_clock_seconds();
    stp_draw *draws = r->cut.draws + begin;
    size_t count = r->cut.draw_count - begin;
    if (stp_frame_asks_headers(r) && !known) {
        STP_TRY(load_round(r, draws, count, true, load, err));
        if (load->damaged)
            goto done;
        count = load->there;
        STP_TRY(stp_frame_refine(r, draws, count, err));
    }
    STP_TRY(load_round(r, draws, count, false, load, err));
done:
    d->stats.load_ms += 1e3 * (stp_clock_seconds() - begun);
    return status;
}

/* Appends a cut's missing blocks to r->wants, at most `limit`; *count counts all wants. */
static stp_status add_wants(stp_renderer *r, const stp_cut *cut, size_t limit, size_t *count,
                            stp_error *err)
{
    size_t more = cut->miss_count < limit ? cut->miss_count : limit;
    stp_status status = stp_grow(&r->wants, &r->want_capacity, *count + more, sizeof *r->wants,
                                 "a list of blocks", err);
    for (size_t i = 0; status == STP_OK && i < cut->miss_count && more > 0; i++) {
        if (stp_block_cache_damaged(r->cache, cut->misses[i].block))
            continue;
        r->wants[(*count)++] = (stp_want){cut->misses[i].block, cut->misses[i].finest};
        more--;
    }
    return status;
}

/* Marks what the cut draws, or falls back on, as used. */
void stp_frame_touch(stp_renderer *r)
{
    for (size_t i = 0; i < r->cut.draw_count; i++)
        stp_block_cache_touch(r->cache, r->cut.draws[i].block, r->stamp);
    for (size_t i = 0; i < r->cut.passed_count; i++)
        stp_block_cache_touch(r->cache, r->cut.passed[i], r->stamp);
}

/* Draws what is resident, to find out what it hides. */
static stp_status guess(stp_renderer *r, stp_drawing *d, stp_error *err)
{
    stp_status status = STP_OK;
    stp_drawing coarse = {.view = d->view, .params = d->params, .waits = true};
    STP_TRY(stp_frame_ready(r, d, err));
    STP_TRY(stp_sight_begin(&r->sight, &r->cut, err));
    STP_TRY(stp_frame_pass(r, &coarse, r->cut.draws, r->cut.draw_count, err));
    STP_TRY(stp_frame_finish(r, &coarse, (double)r->sight.radius_px, err));
    STP_TRY(stp_occlude_guessed(r, err));
    STP_TRY(stp_tiles_begin(&r->tiles, d->view->width, d->view->height,
                            stp_pool_thread_count(r->pool), err));
done:
    return status;
}

/* Whether some model comes from a server. */
static bool is_remote(const stp_renderer *r)
{
    bool remote = false;
    for (size_t i = 0; i < r->scene.model_count; i++)
        remote |= stp_byte_source_is_remote(stp_chunk_file_source(r->scene.models[i].model->file));
    return remote;
}

/* How many bytes the first wants have. */
static uint64_t bytes_of(const stp_renderer *r, size_t count)
{
    uint64_t bytes = 0;
    for (size_t i = 0; i < count; i++)
        bytes += stp_block_payload_bytes(&r->scene.blocks[r->wants[i].block], r->wants[i].finest);
    return bytes;
}

/* What prepare needs. */
typedef struct preparing {
    stp_renderer *r;
    stp_drawing *d;
    uint64_t bytes; /* of the blocks on their way */
    bool drawn;
} preparing;

/* A server that sends 20 Mbit/s takes a fifth of a second for so many bytes. */
#define DRAWN_MEANWHILE_BYTES (512u << 10)

/* Gets ready to draw while blocks are on their way. A driver makes the machine's code of a new
 * program when it first draws with it. If blocks take long, draws what is resident for that. */
static stp_status prepare(void *context, bool *did, stp_error *err)
{
    preparing *p = context;
    stp_renderer *r = p->r;
    stp_status status = STP_OK;
    *did = !p->d->ready || (p->d->compiled && !p->drawn && !r->occluding.on &&
                            p->bytes >= DRAWN_MEANWHILE_BYTES && is_remote(r));
    if (!p->d->ready)
        return stp_frame_ready(r, p->d, err);
    if (!*did)
        return STP_OK;
    p->drawn = true;
    const cut_view view = {r, &r->frame, r->eye, NULL, NULL, false};
    STP_TRY(select_for(r, p->d, &r->cut, &view, true, err));
    STP_TRY(guess(r, p->d, err));
done:
    return status;
}

/* Loads what patches ask for, tier by tier: patches that are there tell which blocks below are
 * needed. *complete: nothing is missing, and the cut is chosen; else there was no more room, and
 * the picture takes passes. */
stp_status stp_frame_load_asked(stp_renderer *r, stp_drawing *d, bool *complete, stp_error *err)
{
    stp_status status = STP_OK;
    const double begun = stp_clock_seconds();
    stp_cache_load load = {0};
    preparing p = {.r = r, .d = d};
    const stp_idle_work idle = {prepare, &p};
    int rounds = 0;
    if (r->keeps) {
        r->stamp++;
        stp_frame_touch(r);
        *complete = true;
        return STP_OK;
    }
    do {
        size_t count = 0;
        cut_view view = {r, &r->frame, r->eye, r->occluding.used, NULL, false};
        STP_TRY(select_for(r, d, &r->cut, &view, true, err));
        if (stp_occlude_wants_guess(r)) {
            STP_TRY(guess(r, d, err));
            view.occlusion = r->occluding.used;
            STP_TRY(select_for(r, d, &r->cut, &view, true, err));
        }
        STP_TRY(add_wants(r, &r->cut, SIZE_MAX, &count, err));
        r->stamp++;
        stp_frame_touch(r);
        p.bytes = bytes_of(r, count);
        const stp_need_below below = {level_above, &view};
        load = (stp_cache_load){
            .wants = r->wants, .below = &below, .idle = &idle, .count = count, .stamp = r->stamp};
        if (count > 0)
            STP_TRY(stp_block_cache_load(r->cache, &load, err));
        if (load.there < load.count)
            stp_occlude_pause(r); /* passes choose by what is resident, so all of it is asked for */
    } while (load.count > 0 && load.there == load.count && ++rounds < ASKED_ROUNDS_LIMIT);
    *complete = load.count == 0;
    r->chosen_state = *complete ? stp_block_cache_state(r->cache) : 0;
done:
    d->stats.load_ms += 1e3 * (stp_clock_seconds() - begun);
    d->ready_ms = 0.0; /* in load_ms */
    return status;
}

/* Requests the blocks that are missing, and the blocks that the camera's motion will reveal. */
stp_status stp_frame_want_missing(stp_renderer *r, const stp_drawing *d, const stp_view *ahead,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    size_t count = 0, now = 0;
    STP_TRY(add_wants(r, &r->cut, STP_STREAM_WANTS_LIMIT, &count, err));
    now = count;
    if (ahead != NULL && count + AHEAD_LIMIT <= STP_STREAM_WANTS_LIMIT) {
        stp_gpu_frame frame = stp_frame_describe(ahead, d->params, &r->scene);
        const stp_dvec3 eye = stp_unexaggerated(d->params, ahead->eye);
        stp_occlusion hidden = {0};
        if (r->occluding.used != NULL) {
            hidden = *r->occluding.used;
            stp_occlusion_aim(&hidden, eye, hidden.margin_px, false);
        }
        const cut_view view = {r, &frame, eye, &hidden, NULL, false};
        STP_TRY(select_for(r, d, &r->ahead_cut, &view, true, err));
        STP_TRY(add_wants(r, &r->ahead_cut, AHEAD_LIMIT, &count, err));
    }
    stp_block_cache_want(r->cache, r->wants, count, now);
done:
    return status;
}
