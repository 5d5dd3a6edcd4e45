/* One frame: cut, load, project, pull, push, shade. */
#include "runtime/colour_range.h"
#include "runtime/stipple.h"

#include "base/clock.h"
#include "base/memory.h"
#include "runtime/chunk_cache.h"
#include "runtime/filter.h"
#include "runtime/gl_context.h"
#include "runtime/inspect.h"
#include "runtime/pick.h"
#include "runtime/pixel_read.h"
#include "runtime/project.h"
#include "runtime/reconstruct.h"
#include "runtime/shader.h"
#include "runtime/sight.h"
#include "runtime/tiles.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Of the geometry shader, a patch. */
#define GEOMETRY_INVOCATIONS 1

struct stp_renderer {
    const stp_model *model;
    stp_pool *pool;
    stp_chunk_cache *cache;
    stp_project project;
    stp_reconstruct_programs reconstruct;
    stp_pyramid pyramid;
    stp_tiles tiles;
    stp_sight sight;
    GLuint frame_buffer; /* uniform block */
    GLuint points_query;
    stp_cut cut;
    stp_gpu_chunk *chunk_records; /* by slot */
    stp_want *wants;
    size_t want_capacity;
    uint64_t stamp; /* counts passes, for the cache */
    char *shader_folder;
    stp_variant variant; /* what the programs are compiled for */
    stp_gpu_frame frame; /* of the last picture */
    stp_dvec3 eye;
    int levels;         /* of the last picture's pyramid, above the viewport */
    const GLuint *kept; /* likewise: its finished pixels where keep_pixels asked for them */
};

/* One picture in the making. */
typedef struct drawing {
    const stp_view *view;
    const stp_draw_params *params;
    stp_draw_stats stats;
    int levels;
} drawing;

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

stp_status stp_renderer_create(stp_renderer **out, const stp_renderer_params *params,
                               stp_error *err)
{
    stp_status status = STP_OK;
    stp_renderer *r = NULL;
    STP_TRY(stp_gl_context_check(err));
    STP_TRY(stp_alloc(&r, 1, sizeof *r, "a renderer", err));
    r->model = params->model;
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
    STP_TRY(stp_chunk_cache_create(&r->cache,
                                   &(stp_chunk_cache_params){.model = params->model,
                                                             .pool = r->pool,
                                                             .gpu_bytes = params->gpu_memory_bytes,
                                                             .cpu_bytes = params->cpu_memory_bytes},
                                   err));
    STP_TRY(stp_alloc(&r->chunk_records, stp_chunk_cache_texture(r->cache)->slot_capacity,
                      sizeof *r->chunk_records, "chunk records", err));
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
    stp_pool_destroy(&r->pool);
    stp_cut_destroy(&r->cut);
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

/* Waiting for the cut: everything that is not damaged will be there. */
static int available_soon(const void *context, uint32_t chunk)
{
    const stp_renderer *r = context;
    return stp_chunk_cache_damaged(r->cache, chunk) ? STP_LEVEL_COUNT : 0;
}

static int available_now(const void *context, uint32_t chunk)
{
    const stp_renderer *r = context;
    return stp_chunk_cache_finest(r->cache, chunk);
}

static stp_status select_cut(stp_renderer *r, bool wait, stp_error *err)
{
    return stp_cut_select(&r->cut,
                          &(stp_cut_params){.model = r->model,
                                            .frame = &r->frame,
                                            .eye = r->eye,
                                            .available = wait ? available_soon : available_now,
                                            .context = r},
                          err);
}

static void set_frame(stp_renderer *r, const drawing *d)
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
    glNamedBufferSubData(r->frame_buffer, 0, sizeof r->frame, &r->frame);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, r->frame_buffer);
    glBindTextures(STP_UNIT_OBJECT_TEXTURE, STP_OBJECT_TEXTURES, texture->textures);
}

/* The records that shaders read of the chunks drawn. */
static void upload_records(stp_renderer *r, const stp_draw *draws, size_t count)
{
    uint32_t first = UINT32_MAX, last = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t slot = stp_chunk_cache_slot(r->cache, draws[i].chunk);
        r->chunk_records[slot] = stp_gpu_chunk_from_draw(r->model, &draws[i], r->eye);
        first = slot < first ? slot : first;
        last = slot > last ? slot : last;
    }
    if (count > 0)
        glNamedBufferSubData(
            stp_chunk_cache_texture(r->cache)->chunks, (GLintptr)(first * sizeof *r->chunk_records),
            (GLsizeiptr)((last - first + 1) * sizeof *r->chunk_records), r->chunk_records + first);
}

/* Greatest projected radius of any sample that may be drawn, pixels. */
static double greatest_radius_px(const stp_renderer *r, const stp_draw *draws, size_t count)
{
    double greatest = 0.0;
    for (size_t i = 0; i < count; i++) {
        const stp_resident *resident =
            stp_chunk_cache_get(r->cache, stp_chunk_cache_slot(r->cache, draws[i].chunk));
        if (draws[i].scale < 0.0f)
            return INFINITY;
        double scale = (double)draws[i].scale;
        double own = (double)resident->radius[draws[i].finest] * scale;
        double coarse = (double)resident->radius[STP_LEVEL_COUNT - 1] * scale;
        coarse = fmin(coarse, r->frame.quality[0] > 0.0f ? (double)r->frame.quality[1] : 0.0);
        greatest = fmax(greatest, fmax(own, coarse));
    }
    return greatest;
}

/* Levels above the viewport that a disc of this radius can reach down from; none for plain points.
 */
static int levels_for(const stp_renderer *r, const drawing *d, double radius_px)
{
    int most = r->pyramid.level_count;
    double levels = radius_px > 0.0 ? ceil(log2(6.0 * radius_px)) : 0.0;
    if (d->params->reconstruct == STP_RECONSTRUCT_POINTS || levels <= 0.0)
        return 0;
    return levels < most ? (int)levels : most;
}

static void begin_pass(stp_renderer *r, bool first)
{
    static const GLuint none[4] = {UINT32_MAX, 0, 0, 0};
    static const float far_depth = 0.0f;
    const stp_pyramid *p = &r->pyramid;
    glBindFramebuffer(GL_FRAMEBUFFER, p->nearest_frame);
    glViewport(0, 0, p->width, p->height);
    glScissor(0, 0, p->width, p->height);
    glClearBufferuiv(GL_COLOR, 0, none);
    if (first)
        glClearBufferfv(GL_DEPTH, 0, &far_depth);
    glEnable(GL_DEPTH_TEST);
}

/* Counts what the last pass's geometry shader emitted, which is asked for late: an answer waits for
 * the GPU. */
static void count_emitted(const stp_renderer *r, drawing *d)
{
    GLuint emitted = 0;
    if (d->params->lod != STP_LOD_GEOMETRY || d->stats.passes == 0)
        return;
    glGetQueryObjectuiv(r->points_query, GL_QUERY_RESULT, &emitted);
    d->stats.points_drawn += emitted;
}

/* Projects draws and resolves what they left nearest. */
static stp_status draw_pass(stp_renderer *r, drawing *d, const stp_draw *draws, size_t count,
                            stp_error *err)
{
    bool first = d->stats.passes == 0;
    double begun = stp_clock_seconds();
    const stp_sight_params sight = {r->model, r->cache, &r->frame, r->eye, r->pool, &r->tiles};
    stp_status status = stp_sight_look(&r->sight, &sight, draws, count, err);
    if (status == STP_OK)
        status = stp_tiles_collect(&r->tiles, first, err);
    if (status != STP_OK)
        return status;
    upload_records(r, draws, count);
    begin_pass(r, first);
    count_emitted(r, d);
    glBeginQuery(GL_PRIMITIVES_GENERATED, r->points_query);
    status = stp_project_draw(&r->project,
                              &(stp_project_params){.model = r->model,
                                                    .cache = r->cache,
                                                    .frame = &r->frame,
                                                    .eye = r->eye,
                                                    .draws = draws,
                                                    .draw_count = count,
                                                    .sight = &r->sight,
                                                    .lod = d->params->lod,
                                                    .pyramid = &r->pyramid,
                                                    .first = first},
                              &d->stats.points_drawn, err);
    glEndQuery(GL_PRIMITIVES_GENERATED);
    if (status != STP_OK)
        return status;
    stp_reconstruct_resolve(&r->reconstruct, &r->pyramid, &r->tiles, first);
    if (d->params->timed)
        glFinish();
    d->stats.passes++;
    d->stats.chunks_drawn += (uint32_t)count;
    d->stats.project_ms += 1e3 * (stp_clock_seconds() - begun);
    return STP_OK;
}

/* Loads draws[0..count) as far as there is room; *loaded of them can be drawn in this pass. */
static stp_status load_draws(stp_renderer *r, drawing *d, const stp_draw *draws, size_t count,
                             size_t *loaded, bool *damaged, stp_error *err)
{
    double begun = stp_clock_seconds();
    stp_status status =
        stp_grow(&r->wants, &r->want_capacity, count, sizeof *r->wants, "a list of chunks", err);
    if (status != STP_OK)
        return status;
    for (size_t i = 0; i < count; i++)
        r->wants[i] = (stp_want){draws[i].chunk, draws[i].finest};
    status = stp_chunk_cache_load(r->cache, r->wants, count, ++r->stamp, 0.0, loaded, damaged, err);
    d->stats.load_ms += 1e3 * (stp_clock_seconds() - begun);
    return status;
}

/* The whole cut, in as many passes as the budget makes of it. */
static stp_status draw_waiting(stp_renderer *r, drawing *d, stp_error *err)
{
    stp_status status = STP_OK;
    size_t begin = 0;
    double radius_px = 0.0;
    bool damaged = false;
    STP_TRY(select_cut(r, true, err));
    do {
        size_t loaded = 0;
        STP_TRY(load_draws(r, d, r->cut.draws + begin, r->cut.draw_count - begin, &loaded, &damaged,
                           err));
        if (damaged) { /* now known: choose again without it */
            STP_TRY(select_cut(r, true, err));
            d->stats = (stp_draw_stats){.load_ms = d->stats.load_ms};
            begin = 0;
            continue;
        }
        if (loaded == 0 && r->cut.draw_count > begin)
            return stp_error_set(err, STP_LIMIT,
                                 "%s: chunk %u does not fit in the GPU memory given: give a larger "
                                 "--gpu-memory",
                                 stp_chunk_file_path(r->model->file), r->cut.draws[begin].chunk);
        radius_px = fmax(radius_px, greatest_radius_px(r, r->cut.draws + begin, loaded));
        d->levels = levels_for(r, d, radius_px);
        STP_TRY(draw_pass(r, d, r->cut.draws + begin, loaded, err));
        begin += loaded;
    } while (begin < r->cut.draw_count || damaged);
done:
    return status;
}

/* What is resident, and then some of what is missing, for the next frame. */
static stp_status draw_at_once(stp_renderer *r, drawing *d, stp_error *err)
{
    stp_status status = STP_OK;
    size_t loaded = 0;
    bool damaged = false;
    STP_TRY(select_cut(r, false, err));
    STP_TRY(load_draws(r, d, r->cut.draws, r->cut.draw_count, &loaded, &damaged, err));
    for (size_t i = 0; i < r->cut.passed_count; i++)
        stp_chunk_cache_touch(r->cache, r->cut.passed[i], r->stamp);
    d->levels = levels_for(r, d, greatest_radius_px(r, r->cut.draws, r->cut.draw_count));
    STP_TRY(draw_pass(r, d, r->cut.draws, r->cut.draw_count, err));
done:
    return status;
}

/* Missing chunks, worst first, until the time for it is over. */
static stp_status load_misses(stp_renderer *r, drawing *d, stp_error *err)
{
    double begun = stp_clock_seconds();
    size_t count = r->cut.miss_count, loaded = 0;
    bool damaged = false;
    stp_status status =
        stp_grow(&r->wants, &r->want_capacity, count, sizeof *r->wants, "a list of chunks", err);
    if (status != STP_OK || count == 0)
        return status;
    for (size_t i = 0; i < count; i++)
        r->wants[i] = (stp_want){r->cut.misses[i].chunk, r->cut.misses[i].finest};
    status = stp_chunk_cache_load(r->cache, r->wants, count, r->stamp,
                                  begun + 1e-3 * d->params->load_ms, &loaded, &damaged, err);
    d->stats.load_ms += 1e3 * (stp_clock_seconds() - begun);
    return status;
}

static void finish_picture(stp_renderer *r, drawing *d)
{
    double begun = stp_clock_seconds();
    stp_tiles_set_levels(&r->tiles, d->levels);
    stp_reconstruct_pull_push(&r->reconstruct, &r->pyramid, d->levels, &r->tiles);
    if (d->params->timed)
        glFinish();
    double pulled = stp_clock_seconds();
    stp_reconstruct_finish(&r->reconstruct, &r->pyramid, d->levels, &r->tiles);
    if (d->params->keep_pixels && d->levels > 0)
        stp_reconstruct_keep_level_0(&r->reconstruct, &r->pyramid, d->levels, &r->tiles);
    const stp_pyramid_level *level = &r->pyramid.levels[0];
    const GLuint *pixels = d->levels > 0 ? level->finished : level->pulled;
    r->kept = d->params->keep_pixels ? pixels : NULL;
    glFinish();
    count_emitted(r, d);
    d->stats.pull_push_ms = 1e3 * (pulled - begun);
    d->stats.shade_ms = 1e3 * (stp_clock_seconds() - pulled);
    d->stats.pyramid_levels = r->levels = d->levels;
    d->stats.chunks_missing = (uint32_t)r->cut.miss_count;
    d->stats.cut_complete = r->cut.miss_count == 0;
}

stp_status stp_renderer_draw(stp_renderer *r, const stp_view *view, const stp_draw_params *params,
                             stp_draw_stats *stats, stp_error *err)
{
    stp_status status = STP_OK;
    drawing d = {.view = view, .params = params};
    STP_TRY(stp_filter_check(params, err));
    r->kept = NULL;
    STP_TRY(choose_programs(r, view, params, err));
    STP_TRY(stp_pyramid_resize(&r->pyramid, view->width, view->height, err));
    STP_TRY(
        stp_tiles_begin(&r->tiles, view->width, view->height, stp_pool_thread_count(r->pool), err));
    double begun = stp_clock_seconds();
    set_frame(r, &d);
    set_state(r);
    if (params->load_ms > 0.0)
        STP_TRY(draw_at_once(r, &d, err));
    else
        STP_TRY(draw_waiting(r, &d, err));
    finish_picture(r, &d);
    d.stats.frame_ms = 1e3 * (stp_clock_seconds() - begun) - d.stats.load_ms;
    if (params->load_ms > 0.0)
        STP_TRY(load_misses(r, &d, err));
    STP_TRY(stp_gl_check("drawing a frame", err));
    if (stats != NULL)
        *stats = d.stats;
done:
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

stp_status stp_renderer_pick(stp_renderer *r, int x, int y, stp_pick *out, stp_error *err)
{
    const stp_pyramid *p = &r->pyramid;
    if (x < 0 || y < 0 || x >= p->width || y >= p->height)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "pixel %d, %d lies outside the picture", x,
                             y);
    if (r->levels > 0) {
        set_state(r);
        stp_reconstruct_keep_pixel(&r->reconstruct, p, r->levels, &r->tiles, x, y);
    }
    return stp_pick_find(out,
                         &(stp_pick_params){.pyramid = p,
                                            .texture = stp_chunk_cache_texture(r->cache),
                                            .frame = &r->frame,
                                            .eye = r->eye,
                                            .levels = r->levels,
                                            .x = x,
                                            .y = y},
                         err);
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

/* Adds what one chunk's patches chose. */
static void measure_chunk(const stp_renderer *r, const stp_draw *draw, stp_cut_measure *out)
{
    const stp_resident *resident =
        stp_chunk_cache_get(r->cache, stp_chunk_cache_slot(r->cache, draw->chunk));
    stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(r->model, draw, r->eye);
    for (uint32_t i = 0; i < r->model->entries[draw->chunk].patch_count; i++) {
        const stp_gpu_patch *patch = &resident->patches[i];
        stp_range parts[STP_PATCH_QUARTERS];
        if (!stp_patch_in_sight(&r->frame, draw, &chunk, patch))
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
        if (stp_chunk_cache_finest(r->cache, r->cut.draws[i].chunk) <= r->cut.draws[i].finest)
            measure_chunk(r, &r->cut.draws[i], out);
}

const char *stp_renderer_damage(const stp_renderer *r)
{
    return stp_chunk_cache_damage(r->cache);
}

uint64_t stp_renderer_bytes_read(const stp_renderer *r)
{
    return stp_chunk_cache_bytes_read(r->cache);
}

stp_inspection stp_renderer_inspect(const stp_renderer *r)
{
    return (stp_inspection){&r->pyramid, &r->cut, r->cache, &r->frame, r->eye};
}
