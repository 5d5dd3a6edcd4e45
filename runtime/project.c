/* The roads of projection. */
#include "runtime/project.h"

#include "base/memory.h"
#include "runtime/shader.h"

#include <stdlib.h>

static stp_status create_programs(stp_project *p, const char *folder, const char *defines,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    stp_program_params patch = {.vertex = "patch.vert",
                                .geometry = "patch.geom",
                                .fragment = "id.frag",
                                .defines = defines,
                                .folder = folder};
    stp_program_params sample = patch;
    sample.vertex = "sample.vert";
    sample.geometry = NULL;
    STP_TRY(stp_program_create(&p->patch_program, &patch, err));
    STP_TRY(stp_program_create(&p->sample_program, &sample, err));
    STP_TRY(stp_scatter_create(&p->scatter, folder, defines, err));
done:
    return status;
}

stp_status stp_project_create(stp_project *out, const char *folder, const char *defines,
                              stp_error *err)
{
    stp_project p = {0};
    stp_status status = create_programs(&p, folder, defines, err);
    if (status == STP_OK) {
        glCreateBuffers(1, &p.index_buffer);
        *out = p;
    } else {
        stp_project_destroy(&p);
    }
    return status;
}

void stp_project_destroy(stp_project *p)
{
    glDeleteProgram(p->patch_program);
    glDeleteProgram(p->sample_program);
    stp_scatter_destroy(&p->scatter);
    if (p->index_buffer != 0)
        glDeleteBuffers(1, &p->index_buffer);
    free(p->indices);
    free(p->runs);
    *p = (stp_project){0};
}

stp_gpu_chunk stp_gpu_chunk_from_draw(const stp_model *model, const stp_draw *draw, stp_dvec3 eye)
{
    const stp_chunk_entry *e = &model->entries[draw->chunk];
    stp_dvec3 offset = stp_dvec3_sub(e->origin, eye);
    return (stp_gpu_chunk){
        .offset = {(float)offset.x, (float)offset.y, (float)offset.z},
        .finest = (uint32_t)draw->finest,
        .drawn_children = {(uint32_t)draw->drawn_children, (uint32_t)(draw->drawn_children >> 32)},
        .id = draw->chunk,
        .depth = e->depth,
    };
}

static stp_status append_run(stp_project *p, uint32_t first, uint32_t count, stp_error *err)
{
    stp_status status = stp_grow(&p->indices, &p->index_capacity, p->index_count + count,
                                 sizeof *p->indices, "a list of samples", err);
    for (uint32_t i = 0; status == STP_OK && i < count; i++)
        p->indices[p->index_count++] = first + i;
    return status;
}

/* Chooses every patch of one chunk and lists the samples. */
static stp_status list_samples(stp_project *p, const stp_model *model,
                               const stp_project_params *params, const stp_draw *draw,
                               stp_error *err)
{
    const stp_chunk_cache *cache = params->cache;
    const stp_resident *r = stp_chunk_cache_get(cache, stp_chunk_cache_slot(cache, draw->chunk));
    stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(model, draw, params->eye);
    uint32_t patch_count = model->entries[draw->chunk].patch_count;
    for (uint32_t i = 0; i < patch_count; i++) {
        const stp_gpu_patch *patch = &r->patches[i];
        stp_levels levels;
        stp_range parts[STP_PATCH_QUARTERS];
        (void)stp_levels_choose(params->frame, &chunk, patch, &levels);
        unsigned part_count = stp_levels_select(patch, &levels, parts);
        for (unsigned k = 0; k < part_count; k++) {
            stp_status status = append_run(p, parts[k].begin, parts[k].count, err);
            if (status != STP_OK)
                return status;
        }
    }
    return STP_OK;
}

/* A driver whose geometry shader is one thread and whose rasteriser others (llvmpipe) gets its
 * parts early by a flush: of so many patches at least, in so many parts at most. */
#define FLUSH_PATCHES 4096
#define FLUSH_PARTS 16

static void draw_patches(stp_project *p, const stp_model *model, const stp_project_params *params,
                         const stp_draw *draws, size_t count)
{
    uint64_t total = 0, since_flush = 0;
    for (size_t i = 0; i < count; i++)
        total += model->entries[draws[i].chunk].patch_count;
    uint64_t part = total / FLUSH_PARTS > FLUSH_PATCHES ? total / FLUSH_PARTS : FLUSH_PATCHES;
    glUseProgram(p->patch_program);
    glBindVertexArray(stp_chunk_cache_texture(params->cache)->empty_array);
    for (size_t i = 0; i < count; i++) {
        uint32_t slot = stp_chunk_cache_slot(params->cache, draws[i].chunk);
        const stp_resident *r = stp_chunk_cache_get(params->cache, slot);
        glDrawArrays(GL_POINTS, (GLint)r->placement.patches.begin,
                     (GLsizei)model->entries[draws[i].chunk].patch_count);
        since_flush += model->entries[draws[i].chunk].patch_count;
        if (since_flush >= part) {
            glFlush();
            since_flush = 0;
        }
    }
}

/* The chunk's origin, for the program of samples. */
static void set_offset(const stp_model *model, const stp_project_params *params,
                       const stp_draw *draw)
{
    stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(model, draw, params->eye);
    glUniform3fv(STP_UNIFORM_CHUNK_OFFSET, 1, chunk.offset);
}

/* Lists the samples of all chunks, uploads the list once and draws each chunk's part. */
static stp_status draw_listed(stp_project *p, const stp_model *model,
                              const stp_project_params *params, const stp_draw *draws, size_t count,
                              uint64_t *points, stp_error *err)
{
    stp_status status = STP_OK;
    size_t *begins = NULL;
    GLuint array = stp_chunk_cache_texture(params->cache)->sample_array;
    STP_TRY(stp_alloc(&begins, count + 1, sizeof *begins, "a list of chunks", err));
    p->index_count = 0;
    for (size_t i = 0; i < count; i++) {
        STP_TRY(list_samples(p, model, params, &draws[i], err));
        begins[i + 1] = p->index_count;
    }
    glNamedBufferData(p->index_buffer, (GLsizeiptr)(p->index_count * sizeof *p->indices),
                      p->indices, GL_STREAM_DRAW);
    glUseProgram(p->sample_program);
    glBindVertexArray(array);
    glVertexArrayElementBuffer(array, p->index_buffer);
    for (size_t i = 0; i < count; i++) {
        if (begins[i + 1] == begins[i])
            continue;
        set_offset(model, params, &draws[i]);
        glDrawElements(GL_POINTS, (GLsizei)(begins[i + 1] - begins[i]), GL_UNSIGNED_INT,
                       (const void *)(begins[i] * sizeof *p->indices));
    }
    *points += p->index_count;
done:
    free(begins);
    return status;
}

/* Runs of level-0 samples of one chunk that may be seen: a patch out of sight ends a run. */
static stp_status list_runs(stp_project *p, const stp_model *model,
                            const stp_project_params *params, const stp_draw *draw,
                            uint64_t *points, stp_error *err)
{
    const stp_chunk_cache *cache = params->cache;
    const stp_resident *r = stp_chunk_cache_get(cache, stp_chunk_cache_slot(cache, draw->chunk));
    stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(model, draw, params->eye);
    uint32_t patch_count = model->entries[draw->chunk].patch_count;
    GLint end = -1;
    p->run_count = 0;
    for (uint32_t i = 0; i < patch_count; i++) {
        const stp_gpu_patch *patch = &r->patches[i];
        stp_levels levels;
        if (!stp_levels_choose(params->frame, &chunk, patch, &levels))
            continue;
        if ((GLint)patch->first[0] != end) {
            stp_status status = stp_grow(&p->runs, &p->run_capacity, p->run_count + 1,
                                         sizeof *p->runs, "a list of runs", err);
            if (status != STP_OK)
                return status;
            p->runs[p->run_count++] = (stp_range){patch->first[0], patch->count[0]};
        } else {
            p->runs[p->run_count - 1].count += patch->count[0];
        }
        end = (GLint)(patch->first[0] + patch->count[0]);
        *points += patch->count[0];
    }
    return STP_OK;
}

/* Every level-0 sample of patches in sight; they stand one after the other, so runs are few. */
static stp_status draw_full(stp_project *p, const stp_model *model,
                            const stp_project_params *params, const stp_draw *draws, size_t count,
                            uint64_t *points, stp_error *err)
{
    glUseProgram(p->sample_program);
    glBindVertexArray(stp_chunk_cache_texture(params->cache)->sample_array);
    for (size_t i = 0; i < count; i++) {
        stp_status status = list_runs(p, model, params, &draws[i], points, err);
        if (status != STP_OK)
            return status;
        set_offset(model, params, &draws[i]);
        for (size_t k = 0; k < p->run_count; k++)
            glDrawArrays(GL_POINTS, (GLint)p->runs[k].begin, (GLsizei)p->runs[k].count);
    }
    return STP_OK;
}

stp_status stp_project_draw(stp_project *p, const stp_model *model,
                            const stp_project_params *params, const stp_draw *draws, size_t count,
                            uint64_t *points, stp_error *err)
{
    if (params->lod == STP_LOD_CPU)
        return draw_listed(p, model, params, draws, count, points, err);
    if (params->lod == STP_LOD_FULL)
        return draw_full(p, model, params, draws, count, points, err);
    if (params->lod == STP_LOD_COMPUTE)
        return stp_scatter_draw(&p->scatter, model, params->cache, params->pyramid, draws, count,
                                params->first, points, err);
    draw_patches(p, model, params, draws, count);
    return STP_OK;
}
