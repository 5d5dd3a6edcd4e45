/* The renderer object: creates and destroys renderers, chooses models and programs, and draws a
 * picture within the host's OpenGL state. frame.c draws a frame, settle.c a view at rest. */
#include "base/clock.h"
#include "base/memory.h"
#include "runtime/draw/composite.h"
#include "runtime/draw/draw_params.h"
#include "runtime/draw/filter.h"
#include "runtime/frame.h"
#include "runtime/frame_load.h"
#include "runtime/frame_pass.h"
#include "runtime/frame_ready.h"
#include "runtime/gl/gl_context.h"
#include "runtime/gl/gl_state.h"
#include "runtime/inspect.h"
#include "runtime/occlude.h"
#include "runtime/renderer_parts.h"
#include "runtime/settle.h"

#include <stdlib.h>
#include <sys/stat.h>

/* Replaces the scene and the cache by those of these models. */
static stp_status open_scene(stp_renderer *r, const stp_model *const *models, size_t count,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_block_cache_destroy(&r->cache);
    stp_scene_destroy(&r->scene);
    free(r->chunk_records);
    r->chunk_records = NULL;
    r->cut.draw_count = r->cut.miss_count = 0;
    r->settling = (stp_settling){0};
    stp_occlude_forget(r);
    r->motion.known = false;
    STP_TRY(stp_scene_create(&r->scene, models, count, err));
    STP_TRY(stp_block_cache_create(
        &r->cache,
        &(stp_block_cache_params){.scene = &r->scene,
                                  .gpu_bytes = r->params.gpu_memory_bytes,
                                  .cpu_bytes = r->params.cpu_memory_bytes,
                                  .thread_count = stp_pool_thread_count(r->pool),
                                  .software = stp_road_is_software(),
                                  .views_follow = r->params.views_follow,
                                  .wake = r->params.wake,
                                  .wake_context = r->params.wake_context},
        err));
    STP_TRY(stp_alloc(&r->chunk_records, stp_block_cache_texture(r->cache)->slot_capacity,
                      sizeof *r->chunk_records, "chunk records", err));
    r->stamp++;
done:
    if (status != STP_OK) {
        stp_block_cache_destroy(&r->cache);
        stp_scene_destroy(&r->scene);
    }
    return status;
}

static stp_status say_nothing_open(stp_error *err)
{
    return stp_error_set(err, STP_IO, "no model can be read any more: open them again");
}

stp_status stp_renderer_set_models(stp_renderer *r, const stp_model *const *models, size_t count,
                                   stp_error *err)
{
    const stp_model *before[STP_SCENE_MODELS_LIMIT];
    size_t before_count = r->scene.model_count;
    stp_gl_state host;
    for (size_t i = 0; i < before_count; i++)
        before[i] = r->scene.models[i].model;
    stp_gl_state_enter(&host);
    stp_status status = open_scene(r, models, count, err);
    if (status != STP_OK && before_count > 0 && open_scene(r, before, before_count, NULL) != STP_OK)
        status = say_nothing_open(err);
    stp_gl_state_leave(&host);
    return status;
}

/* Creates a renderer, between stp_gl_state_enter and leave. */
static stp_status create(stp_renderer **out, const stp_renderer_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_renderer *r = NULL;
    STP_TRY(stp_alloc(&r, 1, sizeof *r, "a renderer", err));
    r->params = *params;
    r->stamp = 1;
    if (params->shader_folder != NULL) {
        struct stat s;
        if (stat(params->shader_folder, &s) != 0 || !S_ISDIR(s.st_mode)) {
            status = stp_error_set(err, STP_NOT_FOUND, "%s: no folder of shaders is there",
                                   params->shader_folder);
            goto done;
        }
        STP_TRY(stp_text_copy(&r->shader_folder, params->shader_folder, "a path", err));
    }
    STP_TRY(stp_pool_create(&r->pool, params->thread_count, err));
    STP_TRY(open_scene(r, &params->model, 1, err));
    stp_road_begin(&r->road, stp_road_is_software());
    glCreateBuffers(1, &r->frame_buffer);
    glNamedBufferStorage(r->frame_buffer, sizeof(stp_gpu_frame), NULL, GL_DYNAMIC_STORAGE_BIT);
    glCreateQueries(GL_PRIMITIVES_GENERATED, 1, &r->points_query);
    stp_stage_clock_create(&r->clock, stp_road_is_software());
    STP_TRY(stp_gl_check("making the renderer", err));
    *out = r;
    r = NULL;
done:
    stp_renderer_destroy(&r);
    return status;
}

stp_status stp_renderer_create(stp_renderer **out, const stp_renderer_params *params,
                               stp_error *err)
{
    stp_gl_state host;
    stp_status status = stp_gl_context_check(err);
    if (status != STP_OK)
        return status;
    stp_gl_state_enter(&host);
    status = create(out, params, err);
    stp_gl_state_leave(&host);
    return status;
}

void stp_renderer_destroy(stp_renderer **renderer)
{
    stp_renderer *r = *renderer;
    if (r == NULL)
        return;
    if (r->frame_buffer != 0) {
        glDeleteBuffers(1, &r->frame_buffer);
        glDeleteQueries(1, &r->points_query);
        stp_stage_clock_destroy(&r->clock);
        stp_road_end(&r->road);
    }
    if (r->reconstruct.resolve != 0) {
        stp_project_destroy(&r->project);
        stp_reconstruct_destroy(&r->reconstruct);
    }
    glDeleteProgram(r->composite);
    stp_pyramid_destroy(&r->pyramid);
    stp_tiles_destroy(&r->tiles);
    stp_pixel_blocks_destroy(&r->blocks);
    stp_sight_destroy(&r->sight);
    stp_fade_destroy(&r->fade);
    stp_occlude_destroy(r);
    stp_block_cache_destroy(&r->cache);
    stp_scene_destroy(&r->scene);
    stp_pool_destroy(&r->pool);
    stp_cut_destroy(&r->cut);
    stp_cut_destroy(&r->ahead_cut);
    free(r->chunk_records);
    free(r->wants);
    free(r->shader_folder);
    free(r);
    *renderer = NULL;
}

stp_status stp_renderer_reload_shaders(stp_renderer *r, stp_error *err)
{
    stp_status status = STP_OK;
    GLuint composite = 0;
    if (r->reconstruct.resolve == 0)
        return STP_OK;
    STP_TRY(stp_composite_create(&composite, r->shader_folder, err));
    STP_TRY(stp_frame_compile(r, &r->variant, r->drawn.lod, err));
    glDeleteProgram(r->composite);
    r->composite = composite;
    composite = 0;
done:
    glDeleteProgram(composite);
    return status;
}

/* Draws a picture by the road that the parameters name: a frame, or a step of a settling
 * picture. */
static stp_status draw_by_road(stp_renderer *r, stp_drawing *d, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_view *view = d->view;
    const stp_draw_params *params = d->params;
    stp_view ahead;
    double begun = stp_clock_seconds();
    if (r->cache == NULL)
        return say_nothing_open(err);
    status = stp_filter_check(params, err);
    if (status != STP_OK)
        return status; /* the last picture stays */
    bool same = r->motion.known && stp_view_equal(view, &r->motion.last);
    r->moves = stp_motion_follow(&r->motion, view, begun, &ahead);
    r->still = same && stp_draw_params_equal(params, &r->drawn);
    r->keeps = false;
    if (!r->still)
        r->settling = (stp_settling){0};
    bool settles = stp_settle_wanted(r, d);
    r->frame = stp_frame_describe(view, params, &r->scene);
    r->eye = stp_unexaggerated(params, view->eye);
    begun = stp_clock_seconds();
    if (settles || !params->stream)
        stp_fade_forget(&r->fade);
    if (settles) {
        stp_occlude_pause(r);
        STP_TRY(stp_frame_ready(r, d, err));
        STP_TRY(stp_settle_step(r, d, err));
    } else {
        stp_block_cache_look(r->cache, &r->frame, r->eye, params->stream);
        r->kept = NULL;
        STP_TRY(stp_tiles_begin(&r->tiles, view->width, view->height,
                                stp_pool_thread_count(r->pool), err));
        STP_TRY(stp_occlude_begin(r, params, err));
        r->keeps = stp_frame_may_keep(r);
        STP_TRY(stp_frame_draw(r, d, r->moves ? &ahead : NULL, err));
    }
    d->stats.frame_ms = 1e3 * (stp_clock_seconds() - begun) - d->stats.load_ms - d->ready_ms;
    STP_TRY(stp_gl_check("drawing a frame", err));
    r->drawn = *params;
    r->last = d->stats;
    if (params->stream)
        d->stats.more =
            !r->still || d->stats.fading || d->stats.exposes || stp_settle_goes_on(r, d);
done:
    if (status != STP_OK) { /* the pyramid no longer holds the last picture */
        r->motion.known = false;
        r->last = (stp_draw_stats){0};
        r->kept = NULL;
        if (r->pyramid.width == 0)
            stp_tiles_destroy(&r->tiles); /* tiles say which parts of the pyramid are empty */
    }
    return status;
}

/* Draws the picture, between stp_gl_state_enter and leave. */
static stp_status draw_one(stp_renderer *r, stp_drawing *d, stp_error *err)
{
    const stp_draw_params *asked = d->params;
    stp_draw_params taken = *asked;
    bool chooses = taken.lod == STP_LOD_AUTO;
    if (chooses) /* another road would begin a settling picture anew */
        taken.lod = r->road_chosen && r->settling.phase != STP_SETTLE_NONE
                        ? r->drawn.lod
                        : stp_road_take(&r->road, taken.stream);
    d->params = &taken;
    stp_status status = draw_by_road(r, d, err);
    d->params = asked;
    r->road_chosen = chooses;
    if (chooses)
        stp_road_leave(&r->road, status == STP_OK && d->stats.cut_complete);
    return status;
}

stp_status stp_renderer_draw(stp_renderer *r, const stp_view *view, const stp_draw_params *params,
                             stp_draw_stats *stats, stp_error *err)
{
    stp_gl_state host;
    stp_gl_state_enter(&host);
    stp_drawing d = {.view = view, .params = params, .waits = true, .counts = host.counting == 0};
    stp_status status = draw_one(r, &d, err);
    stp_gl_state_leave(&host);
    if (status == STP_OK && stats != NULL)
        *stats = d.stats;
    return status;
}

stp_status stp_renderer_draw_into(stp_renderer *r, const stp_view *view,
                                  const stp_draw_params *params, const stp_target *target,
                                  stp_draw_stats *stats, stp_error *err)
{
    stp_status status = STP_OK;
    stp_gl_state host;
    stp_view cut;
    stp_draw_params whole = *params; /* smooth edges would have to blend with the host's pixels */
    whole.smooth_edges = false;
    stp_gl_state_enter(&host);
    stp_drawing d = {.view = &cut, .params = &whole, .waits = params->timed};
    d.counts = d.waits && host.counting == 0;
    STP_TRY(stp_composite_view(&cut, &host, view, err));
    if (r->composite == 0)
        STP_TRY(stp_composite_create(&r->composite, r->shader_folder, err));
    STP_TRY(draw_one(r, &d, err));
    stp_composite_draw(r->composite, r->tiles.array, &r->pyramid, &host, view, target);
    STP_TRY(stp_gl_check("drawing into the host's framebuffer", err));
    if (stats != NULL)
        *stats = d.stats;
done:
    stp_gl_state_leave(&host);
    return status;
}

const char *stp_renderer_damage(const stp_renderer *r)
{
    return r->cache != NULL ? stp_block_cache_damage(r->cache) : "";
}

const char *stp_renderer_trouble(const stp_renderer *r)
{
    return r->cache != NULL ? stp_block_cache_trouble(r->cache) : "";
}

bool stp_renderer_has_news(const stp_renderer *r)
{
    return r->cache != NULL && stp_block_cache_has_news(r->cache);
}

stp_memory_use stp_renderer_memory(const stp_renderer *r)
{
    if (r->cache == NULL)
        return (stp_memory_use){0};
    const stp_budget *b = stp_block_cache_budget(r->cache);
    return (stp_memory_use){stp_block_cache_gpu_used(r->cache), b->gpu_bytes, b->cpu_bytes};
}

uint64_t stp_renderer_gpu_pinned(const stp_renderer *r)
{
    return r->cache != NULL ? stp_block_cache_gpu_pinned(r->cache, r->drawn_stamp) : 0;
}

uint64_t stp_renderer_bytes_read(const stp_renderer *r)
{
    return r->cache != NULL ? stp_block_cache_bytes_read(r->cache) : 0;
}

stp_inspection stp_renderer_inspect(const stp_renderer *r)
{
    return (stp_inspection){
        .pyramid = &r->pyramid,
        .cut = &r->cut,
        .sight = &r->sight,
        .kept = r->keeps,
        .looked = stp_frame_sight(r),
        .cache = r->cache,
        .frame = &r->frame,
        .eye = r->eye,
    };
}
