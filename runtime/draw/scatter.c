/* Runs the compute shaders that project. */
#include "runtime/draw/scatter.h"

#include "runtime/draw/project.h"
#include "runtime/draw/road.h"
#include "runtime/gl/gl_context.h"

#include <stdio.h>

/* Image bindings and a uniform location, the same as in the shaders. */
enum { IMAGE_DEPTH = 0, IMAGE_SAMPLE = 1, IMAGE_PLACES = 4 };
enum { UNIFORM_FIRST_PLACE = 7 };

/* At most so many places are kept for each pixel of the picture, and in all. If there may be more,
 * both passes project. */
#define PLACES_A_PIXEL 16
#define PLACES_LIMIT ((size_t)1 << 26)
#define PLACE_BYTES 8

/* Compiles both passes, if they are not there yet. */
static stp_status prepare(stp_scatter *s, bool keeps, stp_error *err)
{
    stp_status status = STP_OK;
    stp_scatter_passes *passes = &s->passes[keeps];
    char defines[STP_VARIANT_DEFINES_BYTES + 32];
    snprintf(defines, sizeof defines, "%s#define STP_PLACES %d\n", s->defines, keeps);
    if (passes->depth.runs == 0)
        STP_TRY(
            stp_each_create(&passes->depth, "scatter_depth.comp", true, s->folder, defines, err));
    if (passes->name.runs == 0)
        STP_TRY(stp_each_create(&passes->name, "scatter_name.comp", true, s->folder, defines, err));
done:
    return status;
}

stp_status stp_scatter_create(stp_scatter *out, const char *folder, const char *defines,
                              stp_error *err)
{
    stp_scatter s = {.folder = folder};
    snprintf(s.defines, sizeof s.defines, "%s", defines);
    stp_status status = prepare(&s, stp_road_is_software(), err);
    if (status == STP_OK)
        *out = s;
    else
        stp_scatter_destroy(&s);
    return status;
}

void stp_scatter_destroy(stp_scatter *s)
{
    for (int i = 0; i < 2; i++) {
        stp_each_destroy(&s->passes[i].depth);
        stp_each_destroy(&s->passes[i].name);
    }
    if (s->places != 0) {
        glDeleteBuffers(1, &s->places);
        glDeleteTextures(1, &s->places_texture);
    }
    *s = (stp_scatter){0};
}

/* Runs programs for each sample. */
static void visit(const stp_each *each, const stp_runs *runs, const stp_project_params *params)
{
    stp_each_set(each, STP_UNIFORM_FIRST_PASS, params->first);
    stp_runs_each(runs, each, -1);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

/* Whether the first pass keeps the places of samples for the second one: a software driver then
 * takes a sixth less time for both. Not measured on a GPU. */
static bool keeps_places(const stp_runs *runs, const stp_pyramid *pyramid)
{
    const size_t pixels = (size_t)pyramid->width * (size_t)pyramid->height;
    const size_t most = stp_runs_most_places(runs);
    return runs->software && most <= PLACES_A_PIXEL * pixels && most <= PLACES_LIMIT;
}

/* Makes room for the places of the samples: the listed ones come first, then those of quarters. */
static void place(stp_scatter *s, const stp_scatter_passes *passes, const stp_runs *runs)
{
    const stp_each *const each[2] = {&passes->depth, &passes->name};
    const GLuint first = (GLuint)runs->listed_count;
    stp_runs_reserve(&s->places, &s->places_texture, GL_RG32UI, &s->place_bytes,
                     (stp_runs_most_places(runs) + 1) * PLACE_BYTES);
    glBindImageTexture(IMAGE_PLACES, s->places_texture, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RG32UI);
    for (int i = 0; i < 2; i++) {
        glProgramUniform1ui(each[i]->quarters, UNIFORM_FIRST_PLACE, first);
        glProgramUniform1ui(each[i]->runs, UNIFORM_FIRST_PLACE,
                            first + STP_PATCH_QUARTERS * (GLuint)runs->quarter_count);
    }
}

stp_status stp_scatter_draw(stp_scatter *s, stp_runs *runs, const stp_project_params *params,
                            uint64_t *points, stp_error *err)
{
    static const GLuint far_depth = 0;
    const stp_pyramid *pyramid = params->pyramid;
    const stp_sight_list *vertices = &params->sight->lists[STP_SIGHT_VERTICES];
    stp_runs_choose(runs, params, vertices->items, vertices->begin[params->draw_count], false,
                    points);
    stp_stage_end(params->clock, STP_STAGE_CHOOSE);
    const bool keeps = keeps_places(runs, pyramid);
    stp_status status = prepare(s, keeps, err);
    if (status != STP_OK)
        return status;
    const stp_scatter_passes *passes = &s->passes[keeps];
    if (keeps)
        place(s, passes, runs);
    if (params->first)
        glClearTexImage(pyramid->scatter_depth, 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &far_depth);
    glBindImageTexture(IMAGE_DEPTH, pyramid->scatter_depth, 0, GL_FALSE, 0, GL_READ_WRITE,
                       GL_R32UI);
    glBindImageTexture(IMAGE_SAMPLE, pyramid->nearest, 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
    visit(&passes->depth, runs, params);
    stp_each_set(&passes->name, STP_UNIFORM_SETTING, params->waits);
    visit(&passes->name, runs, params);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT |
                    GL_FRAMEBUFFER_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    return stp_gl_check("projecting by compute shaders", err);
}
