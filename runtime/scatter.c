/* Projection by compute shaders. */
#include "runtime/scatter.h"

#include "runtime/gl_context.h"
#include "runtime/project.h"
#include "runtime/shader.h"

/* As in the shader. */
enum { IMAGE_DEPTH = 0, IMAGE_SAMPLE = 1 };

stp_status stp_scatter_create(GLuint *program, const char *folder, const char *defines,
                              stp_error *err)
{
    return stp_program_create(
        program,
        &(stp_program_params){.compute = "scatter.comp", .defines = defines, .folder = folder},
        err);
}

stp_status stp_scatter_draw(GLuint program, stp_runs *runs, const stp_project_params *params,
                            uint64_t *points, stp_error *err)
{
    static const GLuint far_depth = 0;
    const stp_pyramid *pyramid = params->pyramid;
    const stp_sight_list *vertices = &params->sight->lists[STP_SIGHT_VERTICES];
    stp_status status =
        stp_runs_choose(runs, params, vertices->items, vertices->begin[params->draw_count],
                        params->waits, points, err);
    if (status != STP_OK)
        return status;
    stp_stage_end(params->clock, STP_STAGE_CHOOSE);
    if (params->first)
        glClearTexImage(pyramid->scatter_depth, 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &far_depth);
    glUseProgram(program);
    glBindImageTexture(IMAGE_DEPTH, pyramid->scatter_depth, 0, GL_FALSE, 0, GL_READ_WRITE,
                       GL_R32UI);
    glBindImageTexture(IMAGE_SAMPLE, pyramid->nearest, 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
    glUniform1i(STP_UNIFORM_FIRST_PASS, params->first);
    for (int naming = 0; naming < 2; naming++) {
        glUniform1i(STP_UNIFORM_SETTING, naming);
        stp_runs_each(runs, -1);
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    }
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT |
                    GL_FRAMEBUFFER_BARRIER_BIT);
    return stp_gl_check("projecting by compute shaders", err);
}
