/* The screen-space passes. */
#include "runtime/reconstruct.h"

#include "runtime/gpu_layout.h"
#include "runtime/shader.h"

stp_status stp_reconstruct_create(stp_reconstruct_programs *out, const char *folder,
                                  const char *defines, stp_error *err)
{
    stp_reconstruct_programs p = {0};
    GLuint *const programs[5] = {&p.resolve, &p.pull, &p.push, &p.finish, &p.shade};
    static const char *const files[5] = {"resolve.frag", "pull.frag", "push.frag", "finish.frag",
                                         "shade.frag"};
    stp_status status = STP_OK;
    for (int i = 0; i < 5; i++)
        STP_TRY(stp_program_create(programs[i],
                                   &(stp_program_params){.vertex = "screen.vert",
                                                         .fragment = files[i],
                                                         .defines = defines,
                                                         .folder = folder},
                                   err));
    *out = p;
    p = (stp_reconstruct_programs){0};
done:
    stp_reconstruct_destroy(&p);
    return status;
}

void stp_reconstruct_destroy(stp_reconstruct_programs *p)
{
    glDeleteProgram(p->resolve);
    glDeleteProgram(p->pull);
    glDeleteProgram(p->push);
    glDeleteProgram(p->finish);
    glDeleteProgram(p->shade);
    *p = (stp_reconstruct_programs){0};
}

/* The area in the pixels of level l: half as large each level, rounded outwards. */
static stp_rectangle area_of_level(stp_rectangle area, int l)
{
    int x1 = (area.x + area.width + (1 << l) - 1) >> l;
    int y1 = (area.y + area.height + (1 << l) - 1) >> l;
    return (stp_rectangle){area.x >> l, area.y >> l, x1 - (area.x >> l), y1 - (area.y >> l)};
}

static void set_area(const stp_pyramid_level *level, stp_rectangle area, int l)
{
    stp_rectangle a = area_of_level(area, l);
    glViewport(0, 0, level->width, level->height);
    glScissor(a.x, a.y, a.width, a.height);
}

/* Tells the shader which part of the level it reads was written. */
static void set_written(stp_rectangle area, int l)
{
    stp_rectangle a = area_of_level(area, l);
    glUniform4i(STP_UNIFORM_WRITTEN_AREA, a.x, a.y, a.x + a.width, a.y + a.height);
}

static void draw_screen(void)
{
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

/* The screen's triangle lies at depth 0, where only covered pixels are nearer: the others are not
 * even looked at. */
void stp_reconstruct_resolve(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                             stp_rectangle area, bool first)
{
    static const GLuint invalid[4] = {0, 0, 0, 0};
    glBindFramebuffer(GL_FRAMEBUFFER, pyramid->levels[0].pulled_frame);
    set_area(&pyramid->levels[0], area, 0);
    for (int i = 0; first && i < STP_TARGET_COUNT; i++)
        glClearBufferuiv(GL_COLOR, i, invalid);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_FALSE);
    glUseProgram(programs->resolve);
    glBindTextureUnit(STP_UNIT_NEAREST, pyramid->nearest);
    draw_screen();
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_TRUE);
    glDisable(GL_DEPTH_TEST);
}

/* What finishing level l reads. */
static void bind_push(const stp_pyramid *pyramid, int l, int levels, stp_rectangle area)
{
    const stp_pyramid_level *coarse = &pyramid->levels[l + 1];
    set_area(&pyramid->levels[l], area, l);
    glUniform1i(STP_UNIFORM_PYRAMID_LEVEL, l);
    set_written(area, l + 1);
    glBindTextures(STP_UNIT_FINE, STP_TARGET_COUNT, pyramid->levels[l].pulled);
    glBindTextures(STP_UNIT_COARSE, STP_TARGET_COUNT,
                   l + 1 == levels ? coarse->pulled : coarse->finished);
}

void stp_reconstruct_pull_push(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                               int levels, stp_rectangle area)
{
    glUseProgram(programs->pull);
    for (int l = 1; l <= levels; l++) {
        glBindFramebuffer(GL_FRAMEBUFFER, pyramid->levels[l].pulled_frame);
        set_area(&pyramid->levels[l], area, l);
        glUniform1i(STP_UNIFORM_PYRAMID_LEVEL, l);
        set_written(area, l - 1);
        glBindTextures(STP_UNIT_FINE, STP_TARGET_COUNT, pyramid->levels[l - 1].pulled);
        draw_screen();
    }
    glUseProgram(programs->push);
    for (int l = levels - 1; l >= 1 && l < STP_PYRAMID_LEVELS_LIMIT; l--) {
        glBindFramebuffer(GL_FRAMEBUFFER, pyramid->levels[l].finished_frame);
        bind_push(pyramid, l, levels, area);
        draw_screen();
    }
}

void stp_reconstruct_finish(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                            int levels, stp_rectangle area)
{
    static const float empty[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    glBindFramebuffer(GL_FRAMEBUFFER, pyramid->picture_frame);
    glScissor(0, 0, pyramid->width, pyramid->height);
    glClearBufferfv(GL_COLOR, 0, empty);
    glClearBufferfv(GL_COLOR, 1, empty);
    glUseProgram(levels > 0 ? programs->finish : programs->shade);
    if (levels > 0) {
        bind_push(pyramid, 0, levels, area);
    } else {
        set_area(&pyramid->levels[0], area, 0);
        glBindTextures(STP_UNIT_FINE, STP_TARGET_COUNT, pyramid->levels[0].pulled);
    }
    draw_screen();
}

void stp_reconstruct_keep_level_0(const stp_reconstruct_programs *programs,
                                  const stp_pyramid *pyramid, int levels, stp_rectangle area)
{
    glBindFramebuffer(GL_FRAMEBUFFER, pyramid->levels[0].finished_frame);
    glUseProgram(programs->push);
    bind_push(pyramid, 0, levels, area);
    draw_screen();
}
