/* Makes runs of samples from patches, and lists of samples. */
#include "runtime/draw/runs.h"

#include "runtime/draw/project.h"
#include "runtime/draw/road.h"
#include "runtime/gl/gpu_layout.h"
#include "runtime/gl/shader.h"

#include <stddef.h>
#include <stdio.h>

/* The same as in shaders/project/runs.glsl and the shaders' bindings. */
#define GROUP_PATCHES 64u
#define GROUP_SAMPLES 256u
#define RUN_SAMPLES 4
#define DROP_COUNTERS 64
#define DROP_STRIDE 16
enum { IMAGE_RUNS = 2, IMAGE_SEEN = 3 };

#define SEEN_BYTES 64

/* Groups of invocations. Some drivers do not allow more than 65535 in a row. */
#define RUNS_GROUPS_LIMIT 1024
#define ROW_GROUPS 128u

/* The head of the runs' buffer. The group counts of the indirect dispatch come first. */
typedef struct runs_head {
    GLuint groups_x, groups_y, groups_z;
    GLuint run_count, points_listed, unused;
    GLuint dropped[DROP_COUNTERS * DROP_STRIDE];
} runs_head;

stp_status stp_each_create(stp_each *out, const char *file, bool quarters, const char *folder,
                           const char *defines, stp_error *err)
{
    stp_each each = {0};
    GLuint *const programs[3] = {&each.runs, &each.listed, &each.quarters};
    stp_status status = STP_OK;
    for (int i = 0; i < (quarters ? 3 : 2); i++) {
        char lines[STP_VARIANT_DEFINES_BYTES + 64];
        snprintf(lines, sizeof lines, "%s#define STP_LISTED %d\n", defines, i);
        STP_TRY(stp_program_create(
            programs[i], &(stp_program_params){.compute = file, .defines = lines, .folder = folder},
            err));
    }
    *out = each;
    each = (stp_each){0};
done:
    stp_each_destroy(&each);
    return status;
}

void stp_each_destroy(stp_each *each)
{
    glDeleteProgram(each->runs);
    glDeleteProgram(each->listed);
    glDeleteProgram(each->quarters);
    *each = (stp_each){0};
}

void stp_each_set(const stp_each *each, GLint location, GLint value)
{
    glProgramUniform1i(each->runs, location, value);
    glProgramUniform1i(each->listed, location, value);
    if (each->quarters != 0)
        glProgramUniform1i(each->quarters, location, value);
}

stp_status stp_runs_create(stp_runs *out, const char *folder, const char *defines, stp_error *err)
{
    stp_program_params params = {.compute = "runs.comp", .defines = defines, .folder = folder};
    stp_runs r = {0};
    stp_status status = stp_program_create(&r.program, &params, err);
    if (status != STP_OK)
        return status;
    glCreateBuffers(1, &r.patches);
    glCreateBuffers(1, &r.listed);
    glCreateBuffers(1, &r.quarters);
    r.software = stp_road_is_software();
    *out = r;
    return STP_OK;
}

void stp_runs_destroy(stp_runs *r)
{
    const GLuint buffers[5] = {r->patches, r->listed, r->quarters, r->runs, r->seen};
    glDeleteProgram(r->program);
    if (r->patches != 0)
        glDeleteBuffers(5, buffers);
    if (r->textures[0] != 0)
        glDeleteTextures(2, r->textures);
    *r = (stp_runs){0};
}

void stp_runs_reserve(GLuint *buffer, GLuint *texture, GLenum format, size_t *capacity,
                      size_t bytes)
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

/* The greatest number of runs: for each quarter its samples in full runs, plus one run that is not
 * full. */
static size_t most_runs(const stp_project_params *params)
{
    size_t runs =
        STP_PATCH_QUARTERS * params->sight->lists[STP_SIGHT_PATCHES].begin[params->draw_count];
    for (size_t i = 0; i < params->draw_count; i++) {
        const stp_draw *draw = &params->draws[i];
        runs += params->scene->blocks[draw->block].sample_count[draw->finest] / RUN_SAMPLES;
    }
    return runs;
}

static void upload(GLuint buffer, const uint32_t *items, size_t count)
{
    glNamedBufferData(buffer, (GLsizeiptr)(count * sizeof *items), items, GL_STREAM_DRAW);
}

/* Chooses levels, and fills runs and seen. */
static void make_runs(stp_runs *r, const stp_project_params *params)
{
    static const runs_head head = {.groups_x = ROW_GROUPS, .groups_z = 1};
    const size_t patches = r->patch_count, groups = (patches + GROUP_PATCHES - 1) / GROUP_PATCHES;
    r->most_runs = patches > 0 ? most_runs(params) : 0;
    stp_runs_reserve(&r->runs, &r->textures[0], GL_RG32UI, &r->run_bytes,
                     sizeof head + r->most_runs * 2 * sizeof(uint32_t));
    stp_runs_reserve(&r->seen, &r->textures[1], GL_RGBA32UI, &r->seen_bytes, patches * SEEN_BYTES);
    glNamedBufferSubData(r->runs, 0, sizeof head, &head);
    if (patches == 0)
        return;
    upload(r->patches, params->sight->lists[STP_SIGHT_PATCHES].items, patches);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, STP_STORAGE_LISTED, r->patches);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, STP_STORAGE_RUNS, r->runs);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, STP_STORAGE_SEEN, r->seen);
    glUseProgram(r->program);
    glUniform1ui(STP_UNIFORM_SETTING, (GLuint)patches);
    glDispatchCompute((GLuint)(groups < RUNS_GROUPS_LIMIT ? groups : RUNS_GROUPS_LIMIT), 1, 1);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                    GL_BUFFER_UPDATE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
}

void stp_runs_take(stp_runs *r, const uint32_t *listed, size_t count)
{
    upload(r->listed, listed, count);
    r->listed_count = count;
    r->quarter_count = r->patch_count = r->run_count = r->most_runs = 0;
    r->chosen = false;
}

/* Begins to count dropped samples anew. */
static void count_again(const stp_runs *r)
{
    static const GLuint none[DROP_COUNTERS * DROP_STRIDE] = {0};
    glNamedBufferSubData(r->runs, offsetof(runs_head, dropped), sizeof none, none);
}

void stp_runs_choose(stp_runs *r, const stp_project_params *params, const uint32_t *listed,
                     size_t count, bool counts, uint64_t *points)
{
    const stp_sight_list *quarters = &params->sight->lists[STP_SIGHT_QUARTERS];
    const bool keeps = params->keeps && r->chosen;
    runs_head head;
    if (!keeps)
        stp_runs_take(r, listed, count);
    *points += count;
    r->chosen = true;
    r->patch_count = params->sight->lists[STP_SIGHT_PATCHES].begin[params->draw_count];
    r->quarter_count = quarters->begin[params->draw_count];
    if (r->patch_count + r->quarter_count == 0)
        return;
    if (keeps) {
        count_again(r);
    } else {
        upload(r->quarters, quarters->items, r->quarter_count);
        make_runs(r, params);
    }
    if (counts) {
        glGetNamedBufferSubData(r->runs, 0, sizeof head, &head);
        r->run_count = head.run_count;
        *points += head.points_listed;
    }
}

uint64_t stp_runs_count_drawn(const stp_runs *r)
{
    runs_head head;
    if (r->patch_count + r->quarter_count == 0)
        return 0;
    glGetNamedBufferSubData(r->runs, 0, sizeof head, &head);
    uint64_t drawn = head.points_listed;
    for (int i = 0; i < DROP_COUNTERS; i++)
        drawn -= (uint64_t)(int32_t)head.dropped[i * DROP_STRIDE];
    return drawn;
}

size_t stp_runs_places(const stp_runs *r)
{
    return RUN_SAMPLES * r->run_count + r->listed_count;
}

size_t stp_runs_most_places(const stp_runs *r)
{
    return RUN_SAMPLES * r->most_runs + STP_PATCH_QUARTERS * r->quarter_count + r->listed_count;
}

/* Starts as many groups as there are runs; on a GPU as many as there may be, since groups without
 * runs cost it nothing. NVIDIA's driver (580) reads the buffer of an indirect dispatch back, which
 * takes milliseconds; glGetNamedBufferSubData then gave what it had read, without what the groups
 * counted. */
static void dispatch(const stp_runs *r)
{
    const size_t row = (size_t)ROW_GROUPS * GROUP_SAMPLES / RUN_SAMPLES;
    if (!r->software) {
        glDispatchCompute(ROW_GROUPS, (GLuint)(r->most_runs / row + 1), 1);
        return;
    }
    glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, r->runs);
    glDispatchComputeIndirect(0);
}

/* Runs a program for each item of a list. A software driver takes as long for a group without items
 * as for one with some, so there are hardly any of these. */
static void run_listed(GLuint program, GLuint list, size_t count)
{
    const size_t groups = (count + GROUP_SAMPLES - 1) / GROUP_SAMPLES;
    const size_t rows = (groups + RUNS_GROUPS_LIMIT - 1) / RUNS_GROUPS_LIMIT;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, STP_STORAGE_LISTED, list);
    glUseProgram(program);
    glUniform1ui(STP_UNIFORM_VERTICES, (GLuint)count);
    glDispatchCompute((GLuint)((groups + rows - 1) / rows), (GLuint)rows, 1);
}

void stp_runs_each(const stp_runs *r, const stp_each *each, GLint first)
{
    if (r->patch_count + r->quarter_count > 0)
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, STP_STORAGE_RUNS, r->runs);
    if (r->patch_count > 0) {
        glBindImageTexture(IMAGE_RUNS, r->textures[0], 0, GL_FALSE, 0, GL_READ_ONLY, GL_RG32UI);
        glBindImageTexture(IMAGE_SEEN, r->textures[1], 0, GL_FALSE, 0, GL_READ_ONLY, GL_RGBA32UI);
        glUseProgram(each->runs);
        glUniform1ui(first, 0);
        dispatch(r);
    }
    if (r->quarter_count > 0)
        run_listed(each->quarters, r->quarters, r->quarter_count);
    if (r->listed_count > 0) {
        glProgramUniform1ui(each->listed, first, (GLuint)(RUN_SAMPLES * r->run_count));
        run_listed(each->listed, r->listed, r->listed_count);
    }
}
