/* Draws a pass of a picture, what was chosen and is resident, and finishes the picture: projects
 * samples, pulls, pushes, shades. */
#include "runtime/frame_pass.h"

#include "base/clock.h"
#include "runtime/occlude.h"
#include "runtime/renderer_parts.h"

#include <string.h>

/* The road that draws a picture. Segments and triangles are rasterised, so no compute road then.
 * Otherwise a software driver draws every sample by compute shaders: they run on all processors,
 * vertex shaders on one. */
static stp_lod road_of(const stp_variant *variant, stp_lod lod)
{
    bool rasterised = !variant->splat && (variant->lines || variant->triangles);
    if (lod == STP_LOD_FULL && !rasterised && stp_road_is_software())
        return STP_LOD_COMPUTE;
    return rasterised && lod == STP_LOD_COMPUTE ? STP_LOD_GEOMETRY : lod;
}

/* Whether compute shaders reconstruct a picture that has coarser levels. */
static bool computes(const stp_variant *variant, stp_lod lod)
{
    return lod == STP_LOD_COMPUTE || road_of(variant, lod) == STP_LOD_COMPUTE;
}

stp_status stp_frame_prepare_road(stp_project *project, stp_reconstruct_programs *reconstruct,
                                  const char *folder, const stp_variant *variant, stp_lod lod,
                                  stp_error *err)
{
    stp_status status = stp_project_prepare(project, variant, road_of(variant, lod), folder, err);
    if (status == STP_OK && computes(variant, lod) && stp_reconstruct_pushes(reconstruct, 1))
        status = stp_reconstruct_prepare_compute(reconstruct, folder, variant, err);
    return status;
}

stp_status stp_frame_prepare(stp_renderer *r, stp_lod lod, stp_error *err)
{
    return stp_frame_prepare_road(&r->project, &r->reconstruct, r->shader_folder, &r->variant, lod,
                                  err);
}

/* Uploads the records of the drawn blocks for the shaders. */
static void upload_records(stp_renderer *r, const stp_draw *draws, size_t count)
{
    uint32_t first = UINT32_MAX, last = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t slot = stp_block_cache_slot(r->cache, draws[i].block);
        r->chunk_records[slot] = stp_gpu_chunk_from_draw(&r->scene, &draws[i], r->eye);
        memcpy(r->chunk_records[slot].openings, r->sight.openings[i],
               sizeof r->chunk_records[slot].openings);
        first = slot < first ? slot : first;
        last = slot > last ? slot : last;
    }
    if (count > 0)
        glNamedBufferSubData(stp_block_cache_texture(r->cache)->chunks.name,
                             (GLintptr)(first * sizeof *r->chunk_records),
                             (GLsizeiptr)((last - first + 1) * sizeof *r->chunk_records),
                             r->chunk_records + first);
}

/* For templates: at least STP_ELLIPSE_FLOOR of shaders/reconstruct/ellipse.glsl. */
#define ELLIPSE_FLOOR_PX 1.0

/* The number of levels above the viewport from which a disc of this radius can reach down; 0 for
 * splats and points. With templates: the levels up to where windows hold the disc, plus one for the
 * radius that merging adds. */
static int levels_for(const stp_renderer *r, const stp_drawing *d, double radius_px)
{
    int most = r->pyramid.level_count, window_px = r->variant.template_px;
    if (radius_px <= 0.0 || d->params->reconstruct >= STP_RECONSTRUCT_SPLAT)
        return 0;
    double levels = ceil(log2(6.0 * radius_px));
    if (window_px > 0) {
        double wide = 2.0 * fmax(radius_px, ELLIPSE_FLOOR_PX) / (window_px - 1);
        levels = wide > 1.0 ? ceil(log2(wide)) + 1.0 : 0.0;
    }
    return levels <= 0.0 ? 0 : levels < most ? (int)levels : most;
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

/* Adds the points that the last pass's shaders drew, if shaders choose levels: geometry shaders on
 * any road of samples, and compute shaders. Called late, since the answer waits for the GPU. */
static void count_emitted(const stp_renderer *r, stp_drawing *d)
{
    GLuint emitted = 0;
    stp_lod lod = road_of(&r->variant, d->params->lod);
    if (!d->counts || r->variant.splat || d->stats.passes == 0 ||
        (lod != STP_LOD_GEOMETRY && lod != STP_LOD_COMPUTE))
        return;
    glGetQueryObjectuiv(r->points_query, GL_QUERY_RESULT, &emitted);
    d->stats.points_drawn += emitted;
    if (lod == STP_LOD_COMPUTE)
        d->stats.points_drawn += stp_runs_count_drawn(&r->project.runs);
}

stp_sight_params stp_frame_sight(const stp_renderer *r)
{
    return (stp_sight_params){.scene = &r->scene,
                              .cache = r->cache,
                              .frame = &r->frame,
                              .eye = r->eye,
                              .pool = r->pool,
                              .occlusion = stp_occlude_drawn(r)};
}

/* The clock for the frame's stages; NULL if the frame is not timed. */
static stp_stage_clock *clock_of(stp_renderer *r, stp_drawing *d)
{
    r->clock.ms = d->stats.gpu_ms;
    return d->params->timed ? &r->clock : NULL;
}

static stp_project_params params_of(stp_renderer *r, stp_drawing *d, const stp_draw *draws,
                                    size_t count)
{
    return (stp_project_params){.scene = &r->scene,
                                .cache = r->cache,
                                .frame = &r->frame,
                                .eye = r->eye,
                                .draws = draws,
                                .draw_count = count,
                                .sight = &r->sight,
                                .lod = road_of(&r->variant, d->params->lod),
                                .pyramid = &r->pyramid,
                                .tiles = &r->tiles,
                                .first = d->stats.passes == 0,
                                .keeps = r->keeps,
                                .waits = d->waits,
                                .clock = clock_of(r, d)};
}

/* Draws samples, or lists splats. */
static stp_status draw_samples(stp_renderer *r, const stp_project_params *params, uint64_t *points,
                               stp_error *err)
{
    return r->variant.splat ? stp_project_list(&r->project, params, points, err)
                            : stp_project_draw(&r->project, params, points, err);
}

/* Whether some of the draws looked at are squares of grids or maps to be drawn as such. */
static bool has_squares(const stp_renderer *r, size_t draw_count)
{
    return r->sight.lists[STP_SIGHT_SQUARES].begin[draw_count] > 0;
}

/* Turns nearest samples into pixels. After compute shaders, the first pass has rasterised nothing
 * but squares, so depths tell their pixels. */
static void resolve(const stp_renderer *r, const stp_project_params *params)
{
    const bool squares = has_squares(r, params->draw_count);
    const bool apart = squares && params->first && params->lod == STP_LOD_COMPUTE;
    stp_reconstruct_resolve(r->reconstruct.resolve, &r->pyramid, &r->tiles, params->first,
                            apart ? GL_EQUAL : GL_ALWAYS);
    if (squares)
        stp_reconstruct_resolve(r->project.squares.resolve, &r->pyramid, &r->tiles, params->first,
                                apart ? GL_NOTEQUAL : GL_ALWAYS);
}

/* Draws the nearest sample of each pixel; of splats, the one whose interval ends first. */
static stp_status draw_fronts(stp_renderer *r, stp_drawing *d, const stp_draw *draws, size_t count,
                              stp_error *err)
{
    bool first = d->stats.passes == 0;
    stp_project_params params = params_of(r, d, draws, count);
    stp_stage_begin(params.clock);
    begin_pass(r, first);
    count_emitted(r, d);
    if (d->counts)
        glBeginQuery(GL_PRIMITIVES_GENERATED, r->points_query);
    stp_status status = draw_samples(r, &params, &d->stats.points_drawn, err);
    if (status == STP_OK && r->variant.splat)
        stp_splat_draw_fronts(&r->project.splat, &r->tiles);
    if (status == STP_OK)
        stp_project_draw_shapes(&r->project, &params);
    if (d->counts)
        glEndQuery(GL_PRIMITIVES_GENERATED);
    if (status == STP_OK && has_squares(r, count))
        status = stp_project_draw_squares(&r->project, &params, &d->stats.points_drawn, err);
    if (status != STP_OK)
        return status;
    stp_stage_end(params.clock, STP_STAGE_PROJECT);
    resolve(r, &params);
    stp_stage_end(params.clock, STP_STAGE_RESOLVE);
    d->stats.passes++;
    d->stats.chunks_drawn += (uint32_t)count;
    return STP_OK;
}

/* Adds up splats. If their fronts were drawn just now, the splats are listed already. */
static stp_status draw_blends(stp_renderer *r, stp_drawing *d, const stp_draw *draws, size_t count,
                              stp_error *err)
{
    uint64_t again = 0; /* the fronts' samples are counted already */
    stp_status status = STP_OK;
    stp_project_params params = params_of(r, d, draws, count);
    stp_stage_begin(params.clock);
    if (d->part == STP_SPLAT_BLENDS) {
        status = draw_samples(r, &params, &again, err);
        if (status != STP_OK)
            return status;
        stp_stage_end(params.clock, STP_STAGE_PROJECT);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, r->pyramid.sum_frame);
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_ONE, GL_ONE);
    stp_splat_draw_blends(&r->project.splat, &r->pyramid, &r->tiles);
    glDisable(GL_BLEND);
    stp_stage_end(params.clock, STP_STAGE_BLEND);
    return STP_OK;
}

static void clear_sums(const stp_renderer *r)
{
    static const float none[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    glScissor(0, 0, r->pyramid.width, r->pyramid.height);
    for (int i = 0; i < 2; i++)
        glClearNamedFramebufferfv(r->pyramid.sum_frame, GL_COLOR, i, none);
}

/* Squares whose samples are seen with a greater radius than this are drawn as such. The cap of
 * coarser levels says up to where pull and push reconstruct well. */
static void set_squares_px(const stp_renderer *r, const stp_draw_params *params,
                           stp_sight_params *sight)
{
    const bool none = params->reconstruct >= STP_RECONSTRUCT_SPLAT;
    const float cap = r->frame.quality[1];
    sight->grids_px = none || params->grid_draw == STP_GRID_POINTS ? INFINITY
                      : params->grid_draw == STP_GRID_TRIANGLES    ? 0.0f
                                                                   : cap;
    sight->maps_px = none || params->maps_as == STP_MAPS_POINTS ? INFINITY
                     : params->maps_as == STP_MAPS_AUTO         ? cap
                                                                : 0.0f;
}

/* Finds what of the draws is in sight. */
static stp_status look(stp_renderer *r, const stp_drawing *d, const stp_draw *draws, size_t count,
                       stp_error *err)
{
    stp_status status = STP_OK;
    const bool splats = r->variant.splat;
    const uint64_t state = stp_block_cache_state(r->cache);
    stp_sight_params sight = stp_frame_sight(r);
    sight.tiles = &r->tiles;
    sight.vertices = d->params->lod != STP_LOD_FULL;
    sight.quarters =
        sight.vertices && !splats && road_of(&r->variant, d->params->lod) == STP_LOD_COMPUTE;
    set_squares_px(r, d->params, &sight);
    r->looked_state = 0;
    STP_TRY(stp_sight_look(&r->sight, &sight, draws, count, err));
    if (d->stats.passes == 0 && count == r->cut.draw_count && state == r->chosen_state &&
        r->occluding.used == NULL)
        r->looked_state = state;
done:
    return status;
}

stp_status stp_frame_pass(stp_renderer *r, stp_drawing *d, const stp_draw *draws, size_t count,
                          stp_error *err)
{
    stp_status status = STP_OK;
    bool first = d->stats.passes == 0, splats = r->variant.splat;
    double begun = stp_clock_seconds();
    r->keeps = r->keeps && first && count == r->cut.draw_count;
    if (r->keeps)
        stp_tiles_mark_again(&r->tiles);
    else
        STP_TRY(look(r, d, draws, count, err));
    stp_occlude_count(r, d, count);
    if (has_squares(r, count))
        STP_TRY(stp_project_prepare_squares(&r->project, &r->variant, r->shader_folder, err));
    STP_TRY(stp_tiles_collect(&r->tiles, first, err));
    if (!r->keeps)
        upload_records(r, draws, count);
    if (splats && first)
        clear_sums(r);
    if (d->part != STP_SPLAT_BLENDS)
        STP_TRY(draw_fronts(r, d, draws, count, err));
    if (splats && d->part != STP_SPLAT_FRONTS)
        STP_TRY(draw_blends(r, d, draws, count, err));
    d->stats.project_ms += 1e3 * (stp_clock_seconds() - begun);
done:
    return status;
}

stp_splat_part stp_frame_part(const stp_renderer *r, bool fronts_done, size_t begin, size_t count)
{
    if (!r->variant.splat || (begin == 0 && count == r->cut.draw_count && !fronts_done))
        return STP_SPLAT_BOTH;
    return fronts_done ? STP_SPLAT_BLENDS : STP_SPLAT_FRONTS;
}

stp_status stp_frame_finish(stp_renderer *r, stp_drawing *d, double radius_px, stp_error *err)
{
    stp_status status = STP_OK;
    int levels = levels_for(r, d, radius_px);
    const stp_pixel_blocks *blocks = NULL;
    stp_stage_clock *clock = clock_of(r, d);
    double begun = stp_clock_seconds();
    stp_tiles_set_levels(&r->tiles, levels);
    r->pyramid.in_place =
        computes(&r->variant, d->params->lod) && stp_reconstruct_pushes(&r->reconstruct, levels);
    r->pyramid.incomplete = r->cut.miss_count > 0;
    if (r->pyramid.in_place) {
        STP_TRY(stp_pixel_blocks_list(&r->blocks, &r->tiles, levels + 1, err));
        blocks = &r->blocks;
    }
    stp_stage_begin(clock);
    stp_reconstruct_pull_push(&r->reconstruct, &r->pyramid, levels, &r->tiles, blocks, clock);
    double pulled = stp_clock_seconds();
    /* while a picture moves, smooth edges cost more time than they are worth */
    stp_reconstruct_finish(&r->reconstruct, &r->pyramid, levels, &r->tiles, blocks,
                           r->still || !d->params->stream, clock);
    bool finishes = stp_reconstruct_finishes(&r->reconstruct, levels);
    if (d->params->keep_pixels && finishes) {
        stp_reconstruct_keep_level_0(&r->reconstruct, &r->pyramid, levels, &r->tiles);
        stp_stage_end(clock, STP_STAGE_EFFECTS);
    }
    const stp_pyramid_level *level = &r->pyramid.levels[0];
    const GLuint *pixels = finishes ? level->finished : level->pulled;
    r->kept = d->params->keep_pixels ? pixels : NULL;
    STP_TRY(stp_occlude_look(r, levels, err));
    if (d->waits)
        glFinish();
    count_emitted(r, d);
    d->stats.pull_push_ms = 1e3 * (pulled - begun);
    d->stats.shade_ms = 1e3 * (stp_clock_seconds() - pulled);
    d->stats.lod =
        d->params->lod == STP_LOD_FULL ? STP_LOD_FULL : road_of(&r->variant, d->params->lod);
    d->stats.pyramid_levels = levels;
    d->stats.chunks_missing = (uint32_t)r->cut.miss_count;
    d->stats.cut_complete = r->cut.miss_count == 0;
    d->stats.every_sample = d->stats.cut_complete && r->frame.quality[0] <= 0.0f;
done:
    return status;
}

void stp_frame_upload(const stp_renderer *r)
{
    glNamedBufferSubData(r->frame_buffer, 0, sizeof r->frame, &r->frame);
}
