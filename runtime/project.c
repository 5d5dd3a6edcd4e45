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

static stp_status append_run(stp_project *p, uint32_t first, uint32_t count, stp_error *err)
{
    stp_status status = stp_grow(&p->indices, &p->index_capacity, p->index_count + count,
                                 sizeof *p->indices, "a list of samples", err);
    for (uint32_t i = 0; status == STP_OK && i < count; i++)
        p->indices[p->index_count++] = first + i;
    return status;
}

/* What the roads that choose on the CPU read of one draw. */
typedef struct seen_draw {
    const stp_resident *resident;
    const uint32_t *patches; /* in sight */
    size_t count;
    stp_gpu_chunk chunk;
} seen_draw;

static seen_draw see(const stp_project_params *params, size_t i)
{
    const stp_sight *sight = params->sight;
    uint32_t slot = stp_chunk_cache_slot(params->cache, params->draws[i].chunk);
    return (seen_draw){stp_chunk_cache_get(params->cache, slot), sight->patches + sight->begin[i],
                       sight->begin[i + 1] - sight->begin[i],
                       stp_gpu_chunk_from_draw(&params->scene->entries[params->draws[i].chunk],
                                               &params->draws[i], params->eye)};
}

static const stp_gpu_patch *seen_patch(const seen_draw *seen, size_t i)
{
    return &seen->resident->patches[seen->patches[i] - seen->resident->placement.patches.begin];
}

/* Chooses the patches of one chunk and lists the samples. */
static stp_status list_samples(stp_project *p, const stp_project_params *params,
                               const seen_draw *seen, stp_error *err)
{
    for (size_t i = 0; i < seen->count; i++) {
        const stp_gpu_patch *patch = seen_patch(seen, i);
        stp_range parts[STP_PATCH_QUARTERS];
        stp_levels levels = stp_levels_choose(params->frame, &seen->chunk, patch);
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
#define FLUSH_PATCHES 2048
#define FLUSH_PARTS 16

static void draw_patches(stp_project *p, const stp_project_params *params)
{
    const stp_sight *sight = params->sight;
    GLuint array = stp_chunk_cache_texture(params->cache)->empty_array;
    size_t count = sight->begin[params->draw_count];
    size_t part = count / FLUSH_PARTS > FLUSH_PATCHES ? count / FLUSH_PARTS : FLUSH_PATCHES;
    glUseProgram(p->patch_program);
    glBindVertexArray(array);
    glNamedBufferData(p->index_buffer, (GLsizeiptr)(count * sizeof *sight->patches), sight->patches,
                      GL_STREAM_DRAW);
    glVertexArrayElementBuffer(array, p->index_buffer);
    for (size_t i = 0; i < count; i += part) {
        glDrawElements(GL_POINTS, (GLsizei)(count - i < part ? count - i : part), GL_UNSIGNED_INT,
                       (const void *)(i * sizeof *sight->patches));
        glFlush();
    }
}

/* The chunk's origin, for the program of samples. */
static void set_offset(const seen_draw *seen)
{
    glUniform3fv(STP_UNIFORM_CHUNK_OFFSET, 1, seen->chunk.offset);
}

/* Lists the samples of all chunks, uploads the list once and draws each chunk's part. */
static stp_status draw_listed(stp_project *p, const stp_project_params *params, uint64_t *points,
                              stp_error *err)
{
    stp_status status = STP_OK;
    size_t *begins = NULL;
    GLuint array = stp_chunk_cache_texture(params->cache)->sample_array;
    STP_TRY(stp_alloc(&begins, params->draw_count + 1, sizeof *begins, "a list of chunks", err));
    p->index_count = 0;
    for (size_t i = 0; i < params->draw_count; i++) {
        seen_draw seen = see(params, i);
        STP_TRY(list_samples(p, params, &seen, err));
        begins[i + 1] = p->index_count;
    }
    glNamedBufferData(p->index_buffer, (GLsizeiptr)(p->index_count * sizeof *p->indices),
                      p->indices, GL_STREAM_DRAW);
    glUseProgram(p->sample_program);
    glBindVertexArray(array);
    glVertexArrayElementBuffer(array, p->index_buffer);
    for (size_t i = 0; i < params->draw_count; i++) {
        if (begins[i + 1] == begins[i])
            continue;
        seen_draw seen = see(params, i);
        set_offset(&seen);
        glDrawElements(GL_POINTS, (GLsizei)(begins[i + 1] - begins[i]), GL_UNSIGNED_INT,
                       (const void *)(begins[i] * sizeof *p->indices));
    }
    *points += p->index_count;
done:
    free(begins);
    return status;
}

/* Runs of samples of one chunk's patches, of the finest level there: one out of sight ends a run.
 */
static stp_status list_runs(stp_project *p, const seen_draw *seen, uint64_t *points, stp_error *err)
{
    uint32_t level = seen->chunk.finest, end = UINT32_MAX;
    p->run_count = 0;
    for (size_t i = 0; i < seen->count; i++) {
        const stp_gpu_patch *patch = seen_patch(seen, i);
        if (patch->first[level] != end) {
            stp_status status = stp_grow(&p->runs, &p->run_capacity, p->run_count + 1,
                                         sizeof *p->runs, "a list of runs", err);
            if (status != STP_OK)
                return status;
            p->runs[p->run_count++] = (stp_range){patch->first[level], patch->count[level]};
        } else {
            p->runs[p->run_count - 1].count += patch->count[level];
        }
        end = patch->first[level] + patch->count[level];
        *points += patch->count[level];
    }
    return STP_OK;
}

/* Every sample of patches in sight; they stand one after the other, so runs are few. */
static stp_status draw_full(stp_project *p, const stp_project_params *params, uint64_t *points,
                            stp_error *err)
{
    glUseProgram(p->sample_program);
    glBindVertexArray(stp_chunk_cache_texture(params->cache)->sample_array);
    for (size_t i = 0; i < params->draw_count; i++) {
        seen_draw seen = see(params, i);
        stp_status status = list_runs(p, &seen, points, err);
        if (status != STP_OK)
            return status;
        set_offset(&seen);
        for (size_t k = 0; k < p->run_count; k++)
            glDrawArrays(GL_POINTS, (GLint)p->runs[k].begin, (GLsizei)p->runs[k].count);
    }
    return STP_OK;
}

stp_status stp_project_draw(stp_project *p, const stp_project_params *params, uint64_t *points,
                            stp_error *err)
{
    if (params->lod == STP_LOD_CPU)
        return draw_listed(p, params, points, err);
    if (params->lod == STP_LOD_FULL)
        return draw_full(p, params, points, err);
    if (params->lod == STP_LOD_COMPUTE)
        return stp_scatter_draw(&p->scatter, params, points, err);
    draw_patches(p, params);
    return STP_OK;
}
