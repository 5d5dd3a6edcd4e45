/* The screen-space passes. */
#include "runtime/reconstruct.h"

#include "runtime/gpu_layout.h"
#include "runtime/shader.h"

stp_status stp_reconstruct_create(stp_reconstruct_programs *out, const char *folder,
                                  const char *defines, stp_error *err)
{
    stp_reconstruct_programs p = {0};
    GLuint *const programs[4] = {&p.resolve, &p.pull, &p.push, &p.shade};
    static const char *const files[4] = {"resolve.frag", "pull.frag", "push.frag", "shade.frag"};
    stp_status status = STP_OK;
    for (int i = 0; i < 4; i++)
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
    glDeleteProgram(p->shade);
    *p = (stp_reconstruct_programs){0};
}

stp_rectangle stp_rectangle_align(stp_rectangle area, const stp_pyramid *pyramid, int levels)
{
    int x0 = area.x < 0 ? 0 : area.x >> levels << levels;
    int y0 = area.y < 0 ? 0 : area.y >> levels << levels;
    int step = 1 << levels;
    int x1 = (area.x + area.width + step - 1) >> levels << levels;
    int y1 = (area.y + area.height + step - 1) >> levels << levels;
    x1 = x1 < pyramid->width ? x1 : pyramid->width;
    y1 = y1 < pyramid->height ? y1 : pyramid->height;
    return (stp_rectangle){x0, y0, x1 > x0 ? x1 - x0 : 0, y1 > y0 ? y1 - y0 : 0};
}

/* An aligned area in the pixels of level l. */
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

static void draw_screen(void)
{
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void stp_reconstruct_resolve(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                             stp_rectangle area, bool keep)
{
    const stp_pyramid_level *level = &pyramid->levels[0];
    glBindFramebuffer(GL_FRAMEBUFFER, level->pulled_frame);
    set_area(level, area, 0);
    glUseProgram(programs->resolve);
    glUniform1i(STP_UNIFORM_KEEP_OTHERS, keep);
    glBindTextureUnit(STP_UNIT_NEAREST, pyramid->nearest);
    draw_screen();
}

void stp_reconstruct_pull_push(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                               int levels, stp_rectangle area)
{
    glUseProgram(programs->pull);
    for (int l = 1; l <= levels; l++) {
        const stp_pyramid_level *level = &pyramid->levels[l];
        glBindFramebuffer(GL_FRAMEBUFFER, level->pulled_frame);
        set_area(level, area, l);
        glUniform1i(STP_UNIFORM_PYRAMID_LEVEL, l);
        glBindTextures(STP_UNIT_FINE, STP_TARGET_COUNT, pyramid->levels[l - 1].pulled);
        draw_screen();
    }
    glUseProgram(programs->push);
    for (int l = levels - 1; l >= 0; l--) {
        const stp_pyramid_level *level = &pyramid->levels[l];
        const stp_pyramid_level *coarse = &pyramid->levels[l + 1];
        glBindFramebuffer(GL_FRAMEBUFFER, level->finished_frame);
        set_area(level, area, l);
        glUniform1i(STP_UNIFORM_PYRAMID_LEVEL, l);
        stp_rectangle known = area_of_level(area, l + 1);
        glUniform4i(STP_UNIFORM_COARSE_AREA, known.x, known.y, known.x + known.width,
                    known.y + known.height);
        glBindTextures(STP_UNIT_FINE, STP_TARGET_COUNT, level->pulled);
        glBindTextures(STP_UNIT_COARSE, STP_TARGET_COUNT,
                       l + 1 == levels ? coarse->pulled : coarse->finished);
        draw_screen();
    }
}

void stp_reconstruct_shade(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                           int levels, stp_rectangle area)
{
    const stp_pyramid_level *level = &pyramid->levels[0];
    static const float empty[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    glBindFramebuffer(GL_FRAMEBUFFER, pyramid->picture_frame);
    glScissor(0, 0, level->width, level->height);
    glClearBufferfv(GL_COLOR, 0, empty);
    set_area(level, area, 0);
    glUseProgram(programs->shade);
    glUniform1i(STP_UNIFORM_PYRAMID_LEVEL, levels);
    glBindTextures(STP_UNIT_FINE, STP_TARGET_COUNT, levels > 0 ? level->finished : level->pulled);
    draw_screen();
}
