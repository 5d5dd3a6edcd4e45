/* Draws one frame: chooses and loads (frame_load.c), then draws (frame_pass.c). Either waits for
 * the whole cut, in passes if needed (draw_waiting), or draws what is resident (draw_streaming). */
#include "runtime/frame.h"

#include "runtime/frame_load.h"
#include "runtime/frame_pass.h"
#include "runtime/frame_ready.h"
#include "runtime/occlude.h"
#include "runtime/renderer_parts.h"

static stp_status refuse_block(const stp_renderer *r, uint32_t block, stp_error *err)
{
    const stp_block *refused = NULL;
    const stp_scene_model *m = stp_scene_find_block(&r->scene, block, &refused);
    return stp_error_set(
        err, STP_LIMIT,
        "%s: chunk %u does not fit in the GPU memory given: give a larger --gpu-memory",
        stp_chunk_file_path(m->model->file), refused->chunk);
}

/* Draws the whole cut, in as many passes as the budget needs, and waits for blocks. */
static stp_status draw_cut(stp_renderer *r, stp_drawing *d, stp_error *err)
{
    stp_status status = STP_OK;
    size_t begin = 0;
    double radius_px = 0.0;
    bool fronts_done = false; /* splats: an earlier pass drew all fronts */
    bool chosen = false;      /* the cut, with its levels, when all of it was loaded */
    stp_cache_load load;
    if (stp_frame_asks_headers(r))
        STP_TRY(stp_frame_load_asked(r, d, &chosen, err));
    STP_TRY(stp_frame_ready(r, d, err));
    if (!r->keeps)
        STP_TRY(chosen ? stp_sight_begin(&r->sight, &r->cut, err) : stp_frame_select(r, d, err));
    do {
        STP_TRY(stp_frame_load_draws(r, d, begin, chosen, &load, err));
        if (load.damaged) { /* the damage is now known: choose again without the block */
            chosen = false;
            STP_TRY(stp_frame_select(r, d, err));
            d->stats = (stp_draw_stats){.load_ms = d->stats.load_ms};
            begin = 0;
            fronts_done = false;
            continue;
        }
        if (load.there == 0 && r->cut.draw_count > begin)
            return refuse_block(r, r->cut.draws[begin].block, err);
        d->part = stp_frame_part(r, fronts_done, begin, load.there);
        STP_TRY(stp_frame_pass(r, d, r->cut.draws + begin, load.there, err));
        radius_px = fmax(radius_px, (double)r->sight.radius_px);
        begin += load.there;
        if (d->part == STP_SPLAT_FRONTS && begin == r->cut.draw_count) {
            fronts_done = true;
            begin = 0;
        }
    } while (begin < r->cut.draw_count || load.damaged);
    STP_TRY(stp_frame_finish(r, d, radius_px, err));
done:
    return status;
}

/* Draws the picture, and again as long as something that was left out as hidden comes to light. */
static stp_status draw_waiting(stp_renderer *r, stp_drawing *d, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(draw_cut(r, d, err));
    STP_TRY(stp_occlude_end(r, d, err));
    while (d->stats.exposes) {
        d->stats = (stp_draw_stats){.load_ms = d->stats.load_ms};
        stp_occlude_choose(r, false);
        STP_TRY(stp_tiles_begin(&r->tiles, d->view->width, d->view->height,
                                stp_pool_thread_count(r->pool), err));
        STP_TRY(draw_cut(r, d, err));
        STP_TRY(stp_occlude_end(r, d, err));
    }
done:
    return status;
}

/* Draws the resident part of the cut, and requests the missing blocks. */
static stp_status draw_streaming(stp_renderer *r, stp_drawing *d, const stp_view *ahead,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    bool came = stp_block_cache_has_news(r->cache);
    STP_TRY(stp_block_cache_update(r->cache, r->stamp, err));
    r->stamp++;
    r->keeps = r->keeps && stp_frame_may_keep(r);
    if (!r->keeps) {
        STP_TRY(stp_frame_select(r, d, err));
        r->chosen_state = r->moves ? 0 : stp_block_cache_state(r->cache);
    }
    stp_frame_touch(r);
    STP_TRY(stp_frame_want_missing(r, d, ahead, err));
    d->stats.chunks_loading = (uint32_t)stp_block_cache_pending(r->cache);
    STP_TRY(stp_frame_ready(r, d, err));
    STP_TRY(stp_frame_pass(r, d, r->cut.draws, r->cut.draw_count, err));
    STP_TRY(stp_frame_finish(r, d, (double)r->sight.radius_px, err));
    STP_TRY(stp_occlude_end(r, d, err));
    if (r->reconstruct.fade != 0)
        STP_TRY(stp_fade_apply(&r->fade, r->reconstruct.fade, &r->pyramid, &r->tiles, &r->frame,
                               r->eye, d->params->fade, !r->still || came, err));
    d->stats.fading = r->fade.left > 0;
done:
    return status;
}

stp_status stp_frame_draw(stp_renderer *r, stp_drawing *d, const stp_view *ahead, stp_error *err)
{
    stp_status status =
        d->params->stream ? draw_streaming(r, d, ahead, err) : draw_waiting(r, d, err);
    r->drawn_stamp = r->stamp;
    return status;
}

/* Adds the levels that one block's patches choose to the measure. */
static void measure_block(const stp_renderer *r, const stp_draw *draw, stp_cut_measure *out)
{
    const stp_resident *resident =
        stp_block_cache_get(r->cache, stp_block_cache_slot(r->cache, draw->block));
    stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(&r->scene, draw, r->eye);
    stp_sight_params sight = stp_frame_sight(r);
    for (uint32_t i = 0; i < r->scene.blocks[draw->block].patch_count; i++) {
        const stp_mirror_patch *patch = &resident->mirror.patches[i];
        stp_range parts[STP_PATCH_QUARTERS];
        if (!stp_patch_in_sight(&r->sight, &sight, draw, resident->mirror.briefs, i))
            continue;
        stp_levels levels = stp_levels_choose(&r->frame, &chunk, patch);
        out->patches++;
        for (unsigned k = stp_levels_select(patch, &levels, parts); k > 0; k--)
            out->points += parts[k - 1].count;
        for (int q = 0; q < STP_PATCH_QUARTERS && levels.of[q] != STP_LEVEL_SKIP; q++)
            out->max_error_px =
                fmax(out->max_error_px,
                     (double)stp_level_error_px(&r->frame, &chunk, patch, levels.of[q], q));
    }
}

void stp_renderer_measure(const stp_renderer *r, stp_cut_measure *out)
{
    *out = (stp_cut_measure){0};
    for (size_t i = 0; i < r->cut.draw_count; i++)
        if (stp_block_cache_finest(r->cache, r->cut.draws[i].block) <= r->cut.draws[i].finest)
            measure_block(r, &r->cut.draws[i], out);
}
