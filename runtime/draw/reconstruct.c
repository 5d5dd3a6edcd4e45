/* Runs the screen-space passes. */
#include "runtime/draw/reconstruct.h"

#include "runtime/gl/gpu_layout.h"

stp_status stp_reconstruct_create(stp_reconstruct_programs *out, const char *folder,
                                  const stp_variant *variant, stp_error *err)
{
    static const char *const files[9] = {"resolve.frag", "pull.frag",  "push.frag",
                                         "finish.frag",  "shade.frag", "edl.frag",
                                         "fade.frag",    "edge.frag",  "contour.frag"};
    stp_reconstruct_programs p = {0};
    GLuint *const programs[9] = {&p.resolve, &p.pull, &p.push, &p.finish, &p.shade,
                                 &p.edl,     &p.fade, &p.edge, &p.contour};
    const bool wanted[9] = {true,          true,           true,
                            true,          true,           variant->edl,
                            variant->fade, variant->edges, variant->contours};
    char defines[STP_VARIANT_DEFINES_BYTES];
    stp_status status = STP_OK;
    stp_variant_defines(variant, defines);
    for (int i = 0; i < 9; i++)
        if (wanted[i])
            STP_TRY(stp_program_create(programs[i],
                                       &(stp_program_params){.vertex = "screen.vert",
                                                             .fragment = files[i],
                                                             .defines = defines,
                                                             .folder = folder},
                                       err));
    p.template_px = variant->template_px;
    p.splat = variant->splat;
    *out = p;
    p = (stp_reconstruct_programs){0};
done:
    stp_reconstruct_destroy(&p);
    return status;
}

stp_status stp_reconstruct_prepare_compute(stp_reconstruct_programs *p, const char *folder,
                                           const stp_variant *variant, stp_error *err)
{
    static const char *const files[3] = {"pull.comp", "push.comp", "finish.comp"};
    GLuint *const programs[3] = {&p->pull_pairs, &p->push_columns, &p->finish_columns};
    char defines[STP_VARIANT_DEFINES_BYTES];
    stp_status status = STP_OK;
    stp_variant_defines(variant, defines);
    for (int i = 0; i < 3; i++)
        if (*programs[i] == 0)
            STP_TRY(stp_program_create(
                programs[i],
                &(stp_program_params){.compute = files[i], .defines = defines, .folder = folder},
                err));
done:
    return status;
}

void stp_reconstruct_destroy(stp_reconstruct_programs *p)
{
    glDeleteProgram(p->pull_pairs);
    glDeleteProgram(p->push_columns);
    glDeleteProgram(p->finish_columns);
    glDeleteProgram(p->resolve);
    glDeleteProgram(p->pull);
    glDeleteProgram(p->push);
    glDeleteProgram(p->finish);
    glDeleteProgram(p->shade);
    glDeleteProgram(p->fade);
    glDeleteProgram(p->edl);
    glDeleteProgram(p->edge);
    glDeleteProgram(p->contour);
    *p = (stp_reconstruct_programs){0};
}

void stp_reconstruct_resolve(GLuint program, const stp_pyramid *pyramid, const stp_tiles *tiles,
                             bool first, GLenum where)
{
    glBindFramebuffer(GL_FRAMEBUFFER, pyramid->levels[0].pulled_frame);
    glEnable(GL_DEPTH_TEST); /* at depth 0, without writing it */
    glDepthMask(GL_FALSE);
    glDepthFunc(where);
    glUseProgram(program);
    glUniform1i(STP_UNIFORM_FIRST_PASS, first);
    glBindTextureUnit(STP_UNIT_NEAREST, pyramid->nearest);
    stp_tiles_draw(tiles, 0);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_TRUE);
    glDisable(GL_DEPTH_TEST);
}

static void set_read(const stp_pyramid_level *level)
{
    glUniform2i(STP_UNIFORM_READ_SIZE, level->width, level->height);
}

bool stp_reconstruct_finishes(const stp_reconstruct_programs *programs, int levels)
{
    return levels > 0 || programs->template_px != 0 || programs->splat;
}

bool stp_reconstruct_pushes(const stp_reconstruct_programs *programs, int levels)
{
    return levels > 0 && programs->template_px == 0 && !programs->splat;
}

/* The textures of level l as finished; `levels` is the coarsest level. */
static const GLuint *finished(const stp_pyramid *pyramid, int l, int levels)
{
    return l == levels ? pyramid->levels[l].pulled : stp_pyramid_finished(pyramid, l);
}

/* Binds a level's textures: for fetches, or as images for compute shaders. */
typedef void bind_level(GLuint first, GLsizei count, const GLuint *textures);

/* Binds what pushing to level l reads. */
static void bind_push(const stp_pyramid *pyramid, int l, int levels, bind_level *bind)
{
    glUniform1i(STP_UNIFORM_PYRAMID_LEVEL, l);
    glUniform1i(STP_UNIFORM_INCOMPLETE, pyramid->incomplete);
    set_read(&pyramid->levels[l + 1]);
    bind(STP_UNIT_FINE, STP_TARGET_COUNT, pyramid->levels[l].pulled);
    bind(STP_UNIT_COARSE, STP_TARGET_COUNT, finished(pyramid, l + 1, levels));
}

/* Binds what finishing level 0 reads. */
static void bind_finish(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                        int levels)
{
    if (programs->splat) {
        glBindTextures(STP_UNIT_FINE, STP_TARGET_COUNT, pyramid->levels[0].pulled);
        glBindTextureUnit(STP_UNIT_FRONT, pyramid->nearest_depth);
        glBindTextures(STP_UNIT_FRONT + 1, 2, pyramid->sums);
        return;
    }
    if (programs->template_px == 0) {
        bind_push(pyramid, 0, levels, glBindTextures);
        return;
    }
    glUniform1i(STP_UNIFORM_PYRAMID_LEVEL, levels);
    glBindTextures(STP_UNIT_FINE, STP_TARGET_COUNT, pyramid->levels[0].pulled);
    glBindTextures(STP_UNIT_COARSE, STP_TARGET_COUNT, pyramid->pulled_above);
}

/* Makes the writes of compute shaders visible to later commands. */
static void end_compute(void)
{
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                    GL_FRAMEBUFFER_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

static void push_columns(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                         int levels, const stp_pixel_blocks *blocks)
{
    glUseProgram(programs->push_columns);
    for (int l = levels - 1; l >= 1 && l < STP_PYRAMID_LEVELS_LIMIT; l--) {
        const stp_pyramid_level *level = &pyramid->levels[l];
        bind_push(pyramid, l, levels, glBindImageTextures);
        for (GLuint i = 0; i < STP_TARGET_COUNT; i++)
            glBindImageTexture(i, level->pulled[i], 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
        stp_pixel_blocks_run(blocks, level, l);
        end_compute();
    }
}

/* Pushes by rasterised passes. */
static void push_levels(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                        int levels, const stp_tiles *tiles)
{
    glUseProgram(programs->push);
    for (int l = levels - 1; l >= 1 && l < STP_PYRAMID_LEVELS_LIMIT; l--) {
        glBindFramebuffer(GL_FRAMEBUFFER, pyramid->levels[l].finished_frame);
        bind_push(pyramid, l, levels, glBindTextures);
        stp_tiles_draw(tiles, l);
    }
}

/* Does the last push and the shading by a compute shader. Writes every pixel of the tiles. */
static void finish_columns(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                           int levels, const stp_pixel_blocks *blocks, GLuint picture)
{
    const GLuint images[3] = {picture, pyramid->picture_depth, pyramid->picture_mark};
    static const GLenum formats[3] = {GL_R32UI, GL_R32F, GL_R8UI};
    glUseProgram(programs->finish_columns);
    bind_push(pyramid, 0, levels, glBindImageTextures);
    for (GLuint i = 0; i < 3; i++)
        glBindImageTexture(i, images[i], 0, GL_FALSE, 0, GL_WRITE_ONLY, formats[i]);
    stp_pixel_blocks_run(blocks, &pyramid->levels[0], 0);
    end_compute();
}

/* Binds what pulling to level l reads. */
static void bind_pull(const stp_pyramid *pyramid, int l, bind_level *bind)
{
    glUniform1i(STP_UNIFORM_PYRAMID_LEVEL, l);
    set_read(&pyramid->levels[l - 1]);
    bind(STP_UNIT_FINE, STP_TARGET_COUNT, pyramid->levels[l - 1].pulled);
}

/* Pulls levels first..levels by rasterised passes. */
static void pull_levels(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                        int first, int levels, const stp_tiles *tiles)
{
    glUseProgram(programs->pull);
    for (int l = first; l <= levels; l++) {
        glBindFramebuffer(GL_FRAMEBUFFER, pyramid->levels[l].pulled_frame);
        bind_pull(pyramid, l, glBindTextures);
        stp_tiles_draw(tiles, l);
    }
}

/* Pulls levels from 1 on by a compute shader, two at once. Returns the first level not pulled. */
static int pull_pairs(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                      int levels, const stp_pixel_blocks *blocks)
{
    int l = 1;
    glUseProgram(programs->pull_pairs);
    for (; l + 1 <= levels && l + 1 < STP_PYRAMID_LEVELS_LIMIT; l += 2) {
        bind_pull(pyramid, l, glBindImageTextures);
        for (GLuint i = 0; i < 2 * STP_TARGET_COUNT; i++)
            glBindImageTexture(i, pyramid->levels[l + (int)i / 2].pulled[i % STP_TARGET_COUNT], 0,
                               GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
        stp_pixel_blocks_run(blocks, &pyramid->levels[l + 1], l + 1);
        end_compute();
    }
    return l;
}

void stp_reconstruct_pull_push(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                               int levels, const stp_tiles *tiles, const stp_pixel_blocks *blocks,
                               stp_stage_clock *clock)
{
    int first = blocks != NULL ? pull_pairs(programs, pyramid, levels, blocks) : 1;
    pull_levels(programs, pyramid, first, levels, tiles);
    if (levels > 0)
        stp_stage_end(clock, STP_STAGE_PULL);
    if (levels < 2 || programs->template_px != 0)
        return;
    if (blocks != NULL)
        push_columns(programs, pyramid, levels, blocks);
    else
        push_levels(programs, pyramid, levels, tiles);
    stp_stage_end(clock, STP_STAGE_PUSH);
}

/* Multiplies the picture by what a program makes of a texture. */
static void multiply(GLuint program, GLuint texture, const stp_tiles *tiles, GLuint frame)
{
    glBindFramebuffer(GL_FRAMEBUFFER, frame);
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_ZERO, GL_SRC_COLOR);
    glUseProgram(program);
    glBindTextureUnit(STP_UNIT_FINE, texture);
    stp_tiles_draw(tiles, 0);
    glDisable(GL_BLEND);
}

/* Empties the texture that finishing or shading writes for contours, and binds it. */
static void begin_contours(const stp_pyramid *pyramid)
{
    glClearTexImage(pyramid->picture_steps, 0, GL_RGBA, GL_FLOAT, NULL);
    glBindImageTexture(STP_IMAGE_STEPS, pyramid->picture_steps, 0, GL_FALSE, 0, GL_WRITE_ONLY,
                       GL_RGBA32F);
}

/* Draws contours over the picture. */
static void draw_contours(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                          const stp_tiles *tiles, GLuint frame)
{
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    multiply(programs->contour, pyramid->picture_steps, tiles, frame);
}

/* Draws the picture: the rough picture with smooth edges. */
static void smooth_edges(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                         int levels, const stp_tiles *tiles)
{
    const GLuint pictures[2] = {pyramid->rough, pyramid->picture_depth};
    static const float empty[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    glBindFramebuffer(GL_FRAMEBUFFER, pyramid->picture_frames[STP_PICTURE_ALONE]);
    glScissor(0, 0, pyramid->width, pyramid->height);
    glClearBufferfv(GL_COLOR, 0, empty);
    glUseProgram(programs->edge);
    glBindTextures(STP_UNIT_FINE, STP_TARGET_COUNT, pyramid->levels[0].pulled);
    bool pushed = levels > 0 && programs->template_px == 0;
    glUniform1i(STP_UNIFORM_PYRAMID_LEVEL, pushed);
    if (pushed) {
        set_read(&pyramid->levels[1]);
        glBindTextures(STP_UNIT_COARSE, STP_TARGET_COUNT, finished(pyramid, 1, levels));
    }
    glBindTextures(STP_UNIT_EDGE, 2, pictures);
    stp_tiles_draw(tiles, 0);
}

/* Draws the picture by rasterised passes: finishes and shades, or only shades. */
static void finish_raster(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                          int levels, const stp_tiles *tiles, const GLuint *frames)
{
    static const float empty[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    static const GLuint no_mark[4] = {0, 0, 0, 0};
    bool marks = programs->fade != 0;
    glBindFramebuffer(GL_FRAMEBUFFER,
                      frames[marks ? STP_PICTURE_WITH_MARK : STP_PICTURE_WITH_DEPTH]);
    glScissor(0, 0, pyramid->width, pyramid->height);
    glClearBufferfv(GL_COLOR, 0, empty);
    glClearBufferfv(GL_COLOR, 1, empty);
    if (marks)
        glClearBufferuiv(GL_COLOR, 2, no_mark);
    bool finishes = stp_reconstruct_finishes(programs, levels);
    glUseProgram(finishes ? programs->finish : programs->shade);
    if (finishes)
        bind_finish(programs, pyramid, levels);
    else
        glBindTextures(STP_UNIT_FINE, STP_TARGET_COUNT, pyramid->levels[0].pulled);
    stp_tiles_draw(tiles, 0);
}

void stp_reconstruct_finish(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                            int levels, const stp_tiles *tiles, const stp_pixel_blocks *blocks,
                            bool smooth, stp_stage_clock *clock)
{
    smooth = smooth && programs->edge != 0;
    if (programs->contour != 0)
        begin_contours(pyramid);
    const GLuint *frames = smooth ? pyramid->rough_frames : pyramid->picture_frames;
    if (blocks != NULL)
        finish_columns(programs, pyramid, levels, blocks,
                       smooth ? pyramid->rough : pyramid->picture);
    else
        finish_raster(programs, pyramid, levels, tiles, frames);
    stp_stage_end(clock, STP_STAGE_FINISH);
    if (programs->contour != 0)
        draw_contours(programs, pyramid, tiles, frames[STP_PICTURE_ALONE]);
    if (programs->edl != 0) /* eye-dome lighting */
        multiply(programs->edl, pyramid->picture_depth, tiles, frames[STP_PICTURE_ALONE]);
    if (smooth)
        smooth_edges(programs, pyramid, levels, tiles);
    if (programs->contour != 0 || programs->edl != 0 || smooth)
        stp_stage_end(clock, STP_STAGE_EFFECTS);
}

/* Prepares for finishing level 0 into its own framebuffer. */
static void begin_level_0(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                          int levels)
{
    glBindFramebuffer(GL_FRAMEBUFFER, pyramid->levels[0].finished_frame);
    glUseProgram(programs->push);
    bind_finish(programs, pyramid, levels);
}

void stp_reconstruct_keep_level_0(const stp_reconstruct_programs *programs,
                                  const stp_pyramid *pyramid, int levels, const stp_tiles *tiles)
{
    begin_level_0(programs, pyramid, levels);
    stp_tiles_draw_whole(tiles, 0);
}

void stp_reconstruct_keep_pixel(const stp_reconstruct_programs *programs,
                                const stp_pyramid *pyramid, int levels, const stp_tiles *tiles,
                                int x, int y)
{
    begin_level_0(programs, pyramid, levels);
    stp_tiles_draw_pixel(tiles, x, y);
}
