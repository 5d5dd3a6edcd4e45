/* Draws a view at rest in passes until it is complete: a picture that does not fit in GPU memory at
 * once, or one of every sample. Each frame takes one step, without waiting for blocks, and shows
 * the last picture meanwhile. The result is the picture that stp_frame_draw makes if it may
 * wait. */
#include "runtime/settle.h"

#include "runtime/frame_load.h"
#include "runtime/frame_pass.h"
#include "runtime/renderer_parts.h"

/* Whether to go on from a complete picture at the threshold to a picture of every sample. */
static bool may_refine(const stp_renderer *r, const stp_drawing *d)
{
    const stp_settling *s = &r->settling;
    bool had = s->phase == STP_SETTLE_DONE && s->params.lod != STP_LOD_FULL;
    return d->params->refine && (r->last.cut_complete || had) && !r->last.every_sample;
}

bool stp_settle_wanted(const stp_renderer *r, const stp_drawing *d)
{
    if (!d->params->stream || !r->still || r->last.fading || r->last.exposes ||
        r->settling.phase == STP_SETTLE_FAILED)
        return false;
    if (r->settling.phase != STP_SETTLE_NONE)
        return true;
    if (stp_block_cache_rests(r->cache))
        return false;
    bool stuck = !r->last.cut_complete && r->last.chunks_loading == 0;
    return stuck || may_refine(r, d);
}

bool stp_settle_goes_on(const stp_renderer *r, const stp_drawing *d)
{
    switch (r->settling.phase) {
    case STP_SETTLE_RUNS:
        return !r->settling.loading;
    case STP_SETTLE_DONE:
        return may_refine(r, d);
    case STP_SETTLE_NONE:
        return stp_settle_wanted(r, d);
    case STP_SETTLE_FAILED:
        break;
    }
    return false;
}

/* Begins a picture: chooses what to draw. every: every sample. */
static stp_status start(stp_renderer *r, const stp_drawing *d, bool every, stp_error *err)
{
    stp_settling *s = &r->settling;
    stp_status status = stp_tiles_begin(&r->tiles, d->view->width, d->view->height,
                                        stp_pool_thread_count(r->pool), err);
    *s = (stp_settling){.phase = STP_SETTLE_RUNS, .params = *d->params};
    s->params.stream = false;
    if (every)
        s->params.lod = STP_LOD_FULL;
    r->frame = stp_frame_describe(d->view, &s->params, &r->scene);
    if (status == STP_OK)
        status = stp_frame_prepare(r, s->params.lod, err);
    if (status == STP_OK)
        status = stp_frame_select(r, &(stp_drawing){.params = &s->params}, err);
    return status;
}

/* Asks for the blocks of draws. As many as fit make the next pass. */
static stp_status start_load(stp_renderer *r, size_t count, bool headers, stp_error *err)
{
    stp_settling *s = &r->settling;
    stp_status status = stp_frame_list_wants(r, r->cut.draws + s->begin, count, headers, err);
    s->headers = headers;
    s->load = (stp_cache_load){.wants = r->wants, .count = count, .stamp = ++r->stamp};
    s->loading = status == STP_OK;
    return status;
}

/* Draws the pass whose blocks are resident. After the last pass, makes the picture. */
static stp_status draw_loaded(stp_renderer *r, stp_drawing *d, stp_error *err)
{
    stp_settling *s = &r->settling;
    const stp_draw *draws = r->cut.draws + s->begin;
    stp_drawing pass = {.view = d->view,
                        .params = &s->params,
                        .stats = s->stats,
                        .waits = d->waits,
                        .counts = d->counts,
                        .part = stp_frame_part(r, s->fronts_done, s->begin, s->load.there)};
    stp_status status = stp_frame_pass(r, &pass, draws, s->load.there, err);
    if (status != STP_OK)
        return status;
    s->radius_px = fmax(s->radius_px, (double)r->sight.radius_px);
    s->begin += s->load.there;
    s->loading = false;
    if (s->begin == r->cut.draw_count && pass.part == STP_SPLAT_FRONTS) {
        s->fronts_done = true;
        s->begin = 0;
    } else if (s->begin == r->cut.draw_count) {
        status = stp_frame_finish(r, &pass, s->radius_px, err);
        if (status != STP_OK)
            return status;
        s->phase = STP_SETTLE_DONE;
        d->stats = pass.stats;
    }
    s->stats = pass.stats;
    return STP_OK;
}

/* Continues a picture: loads the blocks of a pass, then draws the pass. */
static stp_status run(stp_renderer *r, stp_drawing *d, stp_error *err)
{
    stp_status status = STP_OK;
    stp_settling *s = &r->settling;
    bool finished = false;
    r->frame = stp_frame_describe(d->view, &s->params, &r->scene);
    /* of every sample, patches ask for more */
    stp_block_cache_look(r->cache, &r->frame, r->eye, d->params->stream);
    stp_frame_upload(r);
    if (!s->loading)
        STP_TRY(start_load(r, r->cut.draw_count - s->begin, stp_frame_asks_headers(r), err));
    STP_TRY(stp_block_cache_load_step(r->cache, &s->load, &finished, err));
    d->stats.chunks_loading = (uint32_t)(s->load.count - s->load.there);
    if (!finished)
        return STP_OK;
    if (s->load.damaged)
        return start(r, d, s->params.lod == STP_LOD_FULL, err);
    if (s->load.there == 0 && s->load.count > 0) {
        s->phase = STP_SETTLE_FAILED;
    } else if (s->headers) {
        STP_TRY(stp_frame_refine(r, r->cut.draws + s->begin, s->load.there, err));
        STP_TRY(start_load(r, s->load.there, false, err));
        d->stats.chunks_loading = (uint32_t)s->load.count;
    } else
        STP_TRY(draw_loaded(r, d, err));
done:
    if (status == STP_OK || status == STP_GL || status == STP_OUT_OF_MEMORY)
        return status;
    *s = (stp_settling){0}; /* a read failed: the picture stays until the stream has rested */
    return STP_OK;
}

stp_status stp_settle_step(stp_renderer *r, stp_drawing *d, stp_error *err)
{
    stp_status status = STP_OK;
    stp_settling *s = &r->settling;
    d->stats = r->last;
    d->stats.chunks_loading = 0;
    if (s->phase == STP_SETTLE_NONE || (s->phase == STP_SETTLE_DONE && may_refine(r, d)))
        STP_TRY(start(r, d, may_refine(r, d), err));
    if (s->phase == STP_SETTLE_RUNS)
        STP_TRY(run(r, d, err));
done:
    return status;
}
