/* Runs the compute shaders that project. */
#include "runtime/draw/scatter.h"

#include "runtime/draw/project.h"
#include "runtime/gl/gl_context.h"
#include "runtime/gl/shader.h"

/* Image bindings, the same as in the shaders. */
enum { IMAGE_DEPTH = 0, IMAGE_SAMPLE = 1 };

stp_status stp_scatter_create(stp_scatter *out, const char *folder, const char *defines,
                              stp_error *err)
{
    stp_status status = STP_OK;
    stp_scatter s = {0};
    STP_TRY(stp_each_create(&s.depth, "scatter_depth.comp", folder, defines, err));
    STP_TRY(stp_each_create(&s.name, "scatter_name.comp", folder, defines, err));
    *out = s;
    s = (stp_scatter){0};
done:
    stp_scatter_destroy(&s);
    return status;
}

void stp_scatter_destroy(stp_scatter *s)
{
    stp_each_destroy(&s->depth);
    stp_each_destroy(&s->name);
    *s = (stp_scatter){0};
}

/* Runs programs for each sample. */
static void visit(const stp_each *each, const stp_runs *runs, const stp_project_params *params)
{
    stp_each_set(each, STP_UNIFORM_FIRST_PASS, params->first);
    stp_runs_each(runs, each, -1);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

stp_status stp_scatter_draw(const stp_scatter *s, stp_runs *runs, const stp_project_params *params,
                            uint64_t *points, stp_error *err)
{
    static const GLuint far_depth = 0;
    const stp_pyramid *pyramid = params->pyramid;
    const stp_sight_list *vertices = &params->sight->lists[STP_SIGHT_VERTICES];
    stp_runs_choose(runs, params, vertices->items, vertices->begin[params->draw_count], false,
                    points);
    stp_stage_end(params->clock, STP_STAGE_CHOOSE);
    if (params->first)
        glClearTexImage(pyramid->scatter_depth, 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &far_depth);
    glBindImageTexture(IMAGE_DEPTH, pyramid->scatter_depth, 0, GL_FALSE, 0, GL_READ_WRITE,
                       GL_R32UI);
    glBindImageTexture(IMAGE_SAMPLE, pyramid->nearest, 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
    visit(&s->depth, runs, params);
    stp_each_set(&s->name, STP_UNIFORM_SETTING, params->waits);
    visit(&s->name, runs, params);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT |
                    GL_FRAMEBUFFER_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    return stp_gl_check("projecting by compute shaders", err);
}
