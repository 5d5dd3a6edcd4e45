/* Projection by compute shaders. */
#include "runtime/scatter.h"

#include "base/memory.h"
#include "runtime/gl_context.h"
#include "runtime/project.h"
#include "runtime/shader.h"

#include <stdlib.h>

/* As in shaders/runs.glsl and the shaders' bindings. */
#define GROUP_PATCHES 64u
#define GROUP_SAMPLES 64u
#define RUN_SAMPLES 8
#define SAMPLES_LIMIT (UINT32_C(1) << 29)
enum { BLOCK_PATCHES = 1, BLOCK_VERTICES = 1, BLOCK_RUNS = 2, BLOCK_LATTICES = 3 };
enum { UNIT_RUNS = 9, IMAGE_DEPTH = 0, IMAGE_SAMPLE = 1, UNIFORM_SETTING = 1 };

/* Groups of invocations: more than 65535 in a row are too many for some. */
#define RUNS_GROUPS_LIMIT 1024
#define SCATTER_ROW_GROUPS 128u

/* The runs' buffer begins with this; the groups of the indirect dispatch stand first. */
typedef struct runs_head {
    GLuint groups_x, groups_y, groups_z;
    GLuint run_count, points_drawn, unused;
} runs_head;

stp_status stp_scatter_create(stp_scatter *out, const char *folder, const char *defines,
                              stp_error *err)
{
    stp_status status = STP_OK;
    stp_scatter s = {0};
    stp_program_params runs = {.compute = "runs.comp", .defines = defines, .folder = folder};
    stp_program_params scatter = {.compute = "scatter.comp", .defines = defines, .folder = folder};
    STP_TRY(stp_program_create(&s.runs_program, &runs, err));
    STP_TRY(stp_program_create(&s.scatter_program, &scatter, err));
    glCreateBuffers(1, &s.patches);
    glCreateBuffers(1, &s.vertices);
    *out = s;
    s = (stp_scatter){0};
done:
    stp_scatter_destroy(&s);
    return status;
}

void stp_scatter_destroy(stp_scatter *s)
{
    const GLuint buffers[4] = {s->patches, s->vertices, s->runs, s->lattices};
    glDeleteProgram(s->runs_program);
    glDeleteProgram(s->scatter_program);
    if (s->patches != 0)
        glDeleteBuffers(4, buffers);
    if (s->textures[0] != 0)
        glDeleteTextures(2, s->textures);
    *s = (stp_scatter){0};
}

/* Gives a buffer at least so many bytes, and a texture of it. */
static void reserve(GLuint *buffer, GLuint *texture, GLenum format, size_t *capacity, size_t bytes)
{
    if (bytes <= *capacity)
        return;
    if (*buffer != 0) {
        glDeleteBuffers(1, buffer);
        glDeleteTextures(1, texture);
    }
    *capacity = bytes + bytes / 2;
    glCreateBuffers(1, buffer);
    glNamedBufferStorage(*buffer, (GLsizeiptr)*capacity, NULL, GL_DYNAMIC_STORAGE_BIT);
    glCreateTextures(GL_TEXTURE_BUFFER, 1, texture);
    glTextureBuffer(*texture, format, *buffer);
}

/* Runs there can be at most: of each quarter its samples, the last of them in a run that is not
 * full. */
static size_t most_runs(const stp_project_params *params)
{
    size_t runs =
        STP_PATCH_QUARTERS * params->sight->lists[STP_SIGHT_PATCHES].begin[params->draw_count];
    for (size_t i = 0; i < params->draw_count; i++) {
        const stp_draw *draw = &params->draws[i];
        runs += params->scene->entries[draw->chunk].sample_count[draw->finest] / RUN_SAMPLES;
    }
    return runs;
}

/* Chooses levels: fills runs and lattices. */
static void make_runs(stp_scatter *s, const stp_project_params *params)
{
    static const runs_head head = {.groups_x = SCATTER_ROW_GROUPS, .groups_z = 1};
    size_t patches = params->sight->lists[STP_SIGHT_PATCHES].begin[params->draw_count];
    size_t groups = (patches + GROUP_PATCHES - 1) / GROUP_PATCHES;
    reserve(&s->runs, &s->textures[0], GL_RG32UI, &s->run_bytes,
            sizeof head + most_runs(params) * 2 * sizeof(uint32_t));
    reserve(&s->lattices, &s->textures[1], GL_RGBA32F, &s->lattice_bytes,
            patches * 4 * sizeof(float));
    glNamedBufferSubData(s->runs, 0, sizeof head, &head);
    glNamedBufferData(s->patches,
                      (GLsizeiptr)(patches * sizeof *params->sight->lists[STP_SIGHT_PATCHES].items),
                      params->sight->lists[STP_SIGHT_PATCHES].items, GL_STREAM_DRAW);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, BLOCK_PATCHES, s->patches);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, BLOCK_RUNS, s->runs);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, BLOCK_LATTICES, s->lattices);
    glUseProgram(s->runs_program);
    glUniform1ui(UNIFORM_SETTING, (GLuint)patches);
    glDispatchCompute((GLuint)(groups < RUNS_GROUPS_LIMIT ? groups : RUNS_GROUPS_LIMIT), 1, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                    GL_BUFFER_UPDATE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
}

/* Both passes over the runs, of which the GPU alone knows how many there are, and the vertices. */
static void scatter_samples(const stp_scatter *s, const stp_pyramid *pyramid, size_t vertices)
{
    size_t row = (size_t)SCATTER_ROW_GROUPS * GROUP_SAMPLES;
    glUseProgram(s->scatter_program);
    glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, s->runs);
    glBindTextures(UNIT_RUNS, 2, s->textures);
    glBindImageTexture(IMAGE_DEPTH, pyramid->scatter_depth, 0, GL_FALSE, 0, GL_READ_WRITE,
                       GL_R32UI);
    glBindImageTexture(IMAGE_SAMPLE, pyramid->nearest, 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
    for (int naming = 0; naming < 2; naming++) {
        glUniform1i(UNIFORM_SETTING, naming);
        glUniform1ui(STP_UNIFORM_VERTICES, 0);
        glDispatchComputeIndirect(0);
        glUniform1ui(STP_UNIFORM_VERTICES, (GLuint)vertices);
        glDispatchCompute(SCATTER_ROW_GROUPS, (GLuint)((vertices + row - 1) / row), 1);
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    }
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT |
                    GL_FRAMEBUFFER_BARRIER_BIT);
}

stp_status stp_scatter_draw(stp_scatter *s, const stp_project_params *params, uint64_t *points,
                            stp_error *err)
{
    static const GLuint far_depth = 0;
    runs_head head;
    const stp_sight_list *list = &params->sight->lists[STP_SIGHT_VERTICES];
    if (stp_chunk_cache_texture(params->cache)->sample_ranges.capacity > SAMPLES_LIMIT)
        return stp_error_set(err, STP_LIMIT,
                             "--lod compute counts to %u samples: give a smaller --gpu-memory",
                             SAMPLES_LIMIT);
    if (params->first)
        glClearTexImage(params->pyramid->scatter_depth, 0, GL_RED_INTEGER, GL_UNSIGNED_INT,
                        &far_depth);
    size_t vertices = list->begin[params->draw_count];
    if (params->sight->lists[STP_SIGHT_PATCHES].begin[params->draw_count] + vertices == 0)
        return STP_OK;
    make_runs(s, params);
    glNamedBufferData(s->vertices, (GLsizeiptr)(vertices * sizeof *list->items), list->items,
                      GL_STREAM_DRAW);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, BLOCK_VERTICES, s->vertices);
    scatter_samples(s, params->pyramid, vertices);
    *points += vertices;
    if (params->waits) {
        glGetNamedBufferSubData(s->runs, 0, sizeof head, &head);
        *points += head.points_drawn;
    }
    return stp_gl_check("projecting by compute shaders", err);
}
