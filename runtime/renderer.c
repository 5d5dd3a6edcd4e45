/* One frame: cut, load, project, pull, push, shade. */
#include "runtime/colour_range.h"
#include "runtime/inspect.h"
#include "runtime/renderer_parts.h"

#include "base/clock.h"
#include "base/memory.h"
#include "runtime/filter.h"
#include "runtime/gl_context.h"
#include "runtime/pick.h"
#include "runtime/pixel_read.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Of the geometry shader, a patch. */
#define GEOMETRY_INVOCATIONS 1

static stp_status load_programs(stp_renderer *r, const stp_variant *variant, stp_error *err)
{
    char defines[STP_VARIANT_DEFINES_BYTES];
    stp_project project;
    stp_reconstruct_programs reconstruct;
    stp_variant_defines(variant, defines);
    stp_status status = stp_project_create(&project, r->shader_folder, defines, err);
    if (status != STP_OK)
        return status;
    status = stp_reconstruct_create(&reconstruct, r->shader_folder, variant, err);
    if (status != STP_OK) {
        stp_project_destroy(&project);
        return status;
    }
    stp_project_destroy(&r->project);
    stp_reconstruct_destroy(&r->reconstruct);
    r->project = project;
    r->reconstruct = reconstruct;
    r->variant = *variant;
    return STP_OK;
}

/* The programs for these parameters; those of the last frame do, as a rule. */
static stp_status choose_programs(stp_renderer *r, const stp_view *view,
                                  const stp_draw_params *params, stp_error *err)
{
    stp_variant variant = {
        .orthographic = view->orthographic,
        .box = params->reconstruct == STP_RECONSTRUCT_BOX,
        .keep_back_faces = params->keep_back_faces,
        .clip = params->clip.enabled,
        .classes = stp_filter_hides_classes(params),
        .overlay = stp_filter_has_overlay(params),
        .edl = params->edl > 0.0,
        .colour = (int)params->colour,
        .palette = (int)stp_colour_palette(params),
        .shade = (int)params->shade,
        .geometry_invocations = GEOMETRY_INVOCATIONS,
    };
    if (r->project.patch_program != 0 && stp_variant_equal(&variant, &r->variant))
        return STP_OK;
    return load_programs(r, &variant, err);
}

/* Makes scene and cache of models, in the stead of those there are. */
static stp_status open_scene(stp_renderer *r, const stp_model *const *models, size_t count,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_cache_destroy(&r->cache);
    stp_scene_destroy(&r->scene);
    free(r->chunk_records);
    r->chunk_records = NULL;
    r->cut.draw_count = r->cut.miss_count = 0;
    r->settling = (stp_settling){0};
    r->motion.known = false;
    STP_TRY(stp_scene_create(&r->scene, models, count, err));
    STP_TRY(stp_chunk_cache_create(
        &r->cache,
        &(stp_chunk_cache_params){.scene = &r->scene,
                                  .gpu_bytes = r->params.gpu_memory_bytes,
                                  .cpu_bytes = r->params.cpu_memory_bytes,
                                  .thread_count = stp_pool_thread_count(r->pool),
                                  .wake = r->params.wake,
                                  .wake_context = r->params.wake_context},
        err));
    STP_TRY(stp_alloc(&r->chunk_records, stp_chunk_cache_texture(r->cache)->slot_capacity,
                      sizeof *r->chunk_records, "chunk records", err));
    r->stamp++;
done:
    return status;
}

stp_status stp_renderer_set_models(stp_renderer *r, const stp_model *const *models, size_t count,
                                   stp_error *err)
{
    const stp_model *before[STP_SCENE_MODELS_LIMIT];
    size_t before_count = r->scene.model_count;
    for (size_t i = 0; i < before_count; i++)
        before[i] = r->scene.models[i].model;
    stp_status status = open_scene(r, models, count, err);
    if (status != STP_OK && open_scene(r, before, before_count, NULL) != STP_OK)
        return stp_error_set(err, STP_IO, "no model can be read any more: open them again");
    return status;
}

stp_status stp_renderer_create(stp_renderer **out, const stp_renderer_params *params,
                               stp_error *err)
{
    stp_status status = STP_OK;
    stp_renderer *r = NULL;
    STP_TRY(stp_gl_context_check(err));
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
        size_t bytes = strlen(params->shader_folder) + 1;
        STP_TRY(stp_alloc(&r->shader_folder, bytes, 1, "a path", err));
        memcpy(r->shader_folder, params->shader_folder, bytes);
    }
    STP_TRY(stp_pool_create(&r->pool, params->thread_count, err));
    STP_TRY(open_scene(r, &params->model, 1, err));
    glCreateBuffers(1, &r->frame_buffer);
    glNamedBufferStorage(r->frame_buffer, sizeof(stp_gpu_frame), NULL, GL_DYNAMIC_STORAGE_BIT);
    glCreateQueries(GL_PRIMITIVES_GENERATED, 1, &r->points_query);
    STP_TRY(stp_gl_check("making the renderer", err));
    *out = r;
    r = NULL;
done:
    stp_renderer_destroy(&r);
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
    }
    if (r->project.patch_program != 0) {
        stp_project_destroy(&r->project);
        stp_reconstruct_destroy(&r->reconstruct);
    }
    stp_pyramid_destroy(&r->pyramid);
    stp_tiles_destroy(&r->tiles);
    stp_sight_destroy(&r->sight);
    stp_chunk_cache_destroy(&r->cache);
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
    return r->project.patch_program != 0 ? load_programs(r, &r->variant, err) : STP_OK;
}

static void set_frame(stp_renderer *r, const stp_drawing *d)
{
    const stp_draw_params *params = d->params;
    bool every = params->every_sample || params->lod == STP_LOD_FULL;
    double threshold = params->threshold_px > 0.0 ? params->threshold_px : 1.0;
    double cap = params->radius_cap_px > 0.0 ? params->radius_cap_px : STP_RADIUS_CAP_PX;
    r->frame = stp_gpu_frame_from_view(d->view);
    r->frame.quality[0] = every ? 0.0f : (float)threshold;
    r->frame.quality[1] = (float)cap;
    r->frame.modes[1] = params->keep_back_faces;
    r->eye = d->view->eye;
    stp_colour_range_place(r->frame.colour_range, params, &r->eye);
    stp_filter_place(&r->frame, params, &r->eye);
}

/* Pipeline state of all passes. Depth runs from 1, near, to 0. */
static void set_state(const stp_renderer *r)
{
    const stp_object_texture *texture = stp_chunk_cache_texture(r->cache);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDisable(GL_DITHER);
    glDisable(GL_MULTISAMPLE);
    glDisable(GL_STENCIL_TEST);
    glDisable(GL_FRAMEBUFFER_SRGB);
    glDisable(GL_PROGRAM_POINT_SIZE);
    glPointSize(1.0f);
    glEnable(GL_SCISSOR_TEST);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_GREATER);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    stp_frame_upload(r);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, r->frame_buffer);
    glBindTextures(STP_UNIT_OBJECT_TEXTURE, STP_OBJECT_TEXTURES, texture->textures);
}

stp_status stp_renderer_draw(stp_renderer *r, const stp_view *view, const stp_draw_params *params,
                             stp_draw_stats *stats, stp_error *err)
{
    stp_status status = STP_OK;
    stp_drawing d = {.view = view, .params = params};
    stp_view ahead;
    double begun = stp_clock_seconds();
    STP_TRY(stp_filter_check(params, err));
    bool same = r->motion.known && stp_view_equal(view, &r->motion.last);
    r->moves = stp_motion_follow(&r->motion, view, begun, &ahead);
    r->still = same && memcmp(params, &r->drawn, sizeof *params) == 0;
    if (!r->still)
        r->settling = (stp_settling){0};
    bool settles = stp_settle_wanted(r, &d);
    STP_TRY(choose_programs(r, view, params, err));
    STP_TRY(stp_pyramid_resize(&r->pyramid, view->width, view->height, err));
    set_frame(r, &d);
    set_state(r);
    stp_chunk_cache_look(r->cache, &r->frame, r->eye);
    begun = stp_clock_seconds();
    if (settles) {
        STP_TRY(stp_settle_step(r, &d, err));
    } else {
        r->kept = NULL;
        STP_TRY(stp_tiles_begin(&r->tiles, view->width, view->height,
                                stp_pool_thread_count(r->pool), err));
        STP_TRY(stp_frame_draw(r, &d, r->moves ? &ahead : NULL, err));
    }
    d.stats.frame_ms = 1e3 * (stp_clock_seconds() - begun) - d.stats.load_ms;
    STP_TRY(stp_gl_check("drawing a frame", err));
    r->drawn = *params;
    r->last = d.stats;
    if (stats != NULL)
        *stats = d.stats;
done:
    if (status != STP_OK)
        r->motion.known = false; /* what was drawn is not the last view */
    return status;
}

stp_status stp_renderer_read(stp_renderer *r, uint8_t *rgba, stp_error *err)
{
    const stp_pyramid *p = &r->pyramid;
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTextureImage(p->picture, 0, GL_RGBA, GL_UNSIGNED_BYTE, 4 * p->width * p->height, rgba);
    return stp_gl_check("reading the picture", err);
}

stp_status stp_renderer_depth_at(stp_renderer *r, int x, int y, float *depth, stp_error *err)
{
    const stp_pyramid *p = &r->pyramid;
    if (x < 0 || y < 0 || x >= p->width || y >= p->height)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "pixel %d, %d lies outside the picture", x,
                             y);
    glGetTextureSubImage(p->picture_depth, 0, x, y, 0, 1, 1, 1, GL_RED, GL_FLOAT, sizeof *depth,
                         depth);
    return stp_gl_check("reading a depth", err);
}

/* The finished pixel of the last picture, in the pyramid again. */
static stp_status finish_pixel(stp_renderer *r, int x, int y, stp_error *err)
{
    stp_status status = STP_OK;
    if (r->settling.phase == STP_SETTLE_RUNS) { /* its passes have begun to take level 0's place */
        stp_view view = r->motion.last;
        stp_draw_params params = r->drawn;
        r->motion.known = false;
        STP_TRY(stp_renderer_draw(r, &view, &params, NULL, err));
    }
    if (r->last.pyramid_levels > 0) {
        set_state(r);
        stp_reconstruct_keep_pixel(&r->reconstruct, &r->pyramid, r->last.pyramid_levels, &r->tiles,
                                   x, y);
    }
done:
    return status;
}

stp_status stp_renderer_pick(stp_renderer *r, int x, int y, stp_pick *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_pyramid *p = &r->pyramid;
    if (x < 0 || y < 0 || x >= p->width || y >= p->height)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "pixel %d, %d lies outside the picture", x,
                             y);
    if (!stp_pick_choose(p, &x, &y)) {
        *out = (stp_pick){.chunk = STP_CHUNK_NONE, .level = -1};
        return stp_gl_check("picking", err);
    }
    STP_TRY(finish_pixel(r, x, y, err));
    STP_TRY(stp_pick_find(out,
                          &(stp_pick_params){.pyramid = p,
                                             .texture = stp_chunk_cache_texture(r->cache),
                                             .frame = &r->frame,
                                             .eye = r->eye,
                                             .levels = r->last.pyramid_levels,
                                             .x = x,
                                             .y = y},
                          err));
done:
    return status;
}

stp_status stp_renderer_read_depth(stp_renderer *r, float *depth, stp_error *err)
{
    const stp_pyramid *p = &r->pyramid;
    const size_t bytes = (size_t)p->width * (size_t)p->height * sizeof *depth;
    if (bytes > INT32_MAX)
        return stp_error_set(err, STP_LIMIT, "%d x %d depths are too many to read at once",
                             p->width, p->height);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glGetTextureImage(p->picture_depth, 0, GL_RED, GL_FLOAT, (GLsizei)bytes, depth);
    return stp_gl_check("reading depths", err);
}

stp_status stp_renderer_read_normals(stp_renderer *r, float *xyz, stp_error *err)
{
    if (r->kept == NULL)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the last picture was not drawn with keep_pixels: its normals are "
                             "gone");
    return stp_pixel_read_normals(r->kept, &r->frame, xyz, err);
}

void stp_renderer_present(stp_renderer *r, unsigned framebuffer, int width, int height)
{
    glDisable(GL_SCISSOR_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, width, height); /* software drivers ask for a window's new size only here */
    glBlitNamedFramebuffer(r->pyramid.picture_frame, framebuffer, 0, 0, r->pyramid.width,
                           r->pyramid.height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

const char *stp_renderer_damage(const stp_renderer *r)
{
    return stp_chunk_cache_damage(r->cache);
}

const char *stp_renderer_trouble(const stp_renderer *r)
{
    return stp_chunk_cache_trouble(r->cache);
}

bool stp_renderer_has_news(const stp_renderer *r)
{
    return stp_chunk_cache_has_news(r->cache);
}

stp_memory_use stp_renderer_memory(const stp_renderer *r)
{
    const stp_budget *b = stp_chunk_cache_budget(r->cache);
    return (stp_memory_use){stp_chunk_cache_gpu_used(r->cache), b->gpu_bytes, b->cpu_bytes};
}

uint64_t stp_renderer_bytes_read(const stp_renderer *r)
{
    return stp_chunk_cache_bytes_read(r->cache);
}

stp_inspection stp_renderer_inspect(const stp_renderer *r)
{
    return (stp_inspection){&r->pyramid, &r->cut, r->cache, &r->frame, r->eye};
}
