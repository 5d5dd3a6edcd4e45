/* Projects samples, on each of the roads. */
#include "runtime/draw/project.h"

#include "base/memory.h"
#include "runtime/gl/shader.h"

#include <stdio.h>
#include <stdlib.h>

/* Compiles a program that takes patches, if it is not there yet. */
static stp_status prepare_patches(GLuint *program, const char *geometry, const char *fragment,
                                  const char *folder, const char *defines, stp_error *err)
{
    if (*program != 0)
        return STP_OK;
    return stp_program_create(program,
                              &(stp_program_params){.vertex = "patch.vert",
                                                    .geometry = geometry,
                                                    .fragment = fragment,
                                                    .defines = defines,
                                                    .folder = folder},
                              err);
}

/* Compiles a program that takes samples: patch vertices, or any. */
static stp_status prepare_samples(GLuint *program, bool vertices, const char *folder,
                                  const char *defines, stp_error *err)
{
    char lines[STP_VARIANT_DEFINES_BYTES + 32];
    if (*program != 0)
        return STP_OK;
    snprintf(lines, sizeof lines, "%s#define STP_VERTICES %d\n", defines, vertices);
    return stp_program_create(
        program,
        &(stp_program_params){
            .vertex = "sample.vert", .fragment = "id.frag", .defines = lines, .folder = folder},
        err);
}

static stp_status prepare_shapes(stp_project *p, const stp_variant *variant, const char *folder,
                                 const char *defines, stp_error *err)
{
    stp_status status = STP_OK;
    const char *fragment = variant->splat ? "shape_front.frag" : "shape.frag";
    if (variant->lines && !variant->splat)
        STP_TRY(prepare_patches(&p->strip_program, "strip.geom", fragment, folder, defines, err));
    if (variant->lines)
        STP_TRY(
            prepare_patches(&p->wide_program, "strip_wide.geom", fragment, folder, defines, err));
    if (variant->triangles)
        STP_TRY(
            prepare_patches(&p->triangle_program, "triangle.geom", fragment, folder, defines, err));
done:
    return status;
}

static stp_status prepare_pixels(stp_project *p, stp_lod lod, const char *folder,
                                 const char *defines, stp_error *err)
{
    stp_status status = STP_OK;
    if (lod == STP_LOD_COMPUTE && p->runs.program == 0)
        STP_TRY(stp_runs_create(&p->runs, folder, defines, err));
    if (lod == STP_LOD_COMPUTE && p->scatter.defines[0] == '\0')
        STP_TRY(stp_scatter_create(&p->scatter, folder, defines, err));
    if (lod == STP_LOD_GEOMETRY || lod == STP_LOD_CPU)
        STP_TRY(prepare_samples(&p->vertex_program, true, folder, defines, err));
    if (lod == STP_LOD_FULL || lod == STP_LOD_CPU)
        STP_TRY(prepare_samples(&p->sample_program, false, folder, defines, err));
    if (lod == STP_LOD_GEOMETRY)
        STP_TRY(prepare_patches(&p->patch_program, "patch.geom", "id.frag", folder, defines, err));
done:
    return status;
}

stp_status stp_project_prepare(stp_project *p, const stp_variant *variant, stp_lod lod,
                               const char *folder, stp_error *err)
{
    stp_status status = STP_OK;
    char defines[STP_VARIANT_DEFINES_BYTES];
    stp_variant_defines(variant, defines);
    if (p->index_buffer == 0)
        glCreateBuffers(1, &p->index_buffer);
    STP_TRY(prepare_shapes(p, variant, folder, defines, err));
    if (!variant->splat)
        return prepare_pixels(p, lod, folder, defines, err);
    if (p->runs.program == 0)
        STP_TRY(stp_runs_create(&p->runs, folder, defines, err));
    if (p->splat.list.runs == 0)
        STP_TRY(stp_splat_create(&p->splat, false, folder, defines, err));
done:
    return status;
}

/* Compiles the programs that draw squares as triangles, if they are not there yet. */
static stp_status prepare_squares(stp_squares *s, const char *folder, const char *defines,
                                  stp_error *err)
{
    GLuint *const programs[3] = {&s->list, &s->list_quarters, &s->program};
    const stp_program_params params[3] = {
        {.compute = "square.comp", .defines = defines, .folder = folder},
        {.compute = "square_quarters.comp", .defines = defines, .folder = folder},
        {.vertex = "square.vert", .fragment = "shape.frag", .defines = defines, .folder = folder}};
    stp_status status = STP_OK;
    for (int i = 0; i < 3 && status == STP_OK; i++)
        if (*programs[i] == 0)
            status = stp_program_create(programs[i], &params[i], err);
    return status;
}

stp_status stp_project_prepare_squares(stp_project *p, const stp_variant *variant,
                                       const char *folder, stp_error *err)
{
    stp_variant of_squares = *variant;
    char defines[STP_VARIANT_DEFINES_BYTES];
    of_squares.squares = true;
    stp_variant_defines(&of_squares, defines);
    stp_status status = STP_OK;
    STP_TRY(prepare_squares(&p->squares, folder, defines, err));
    p->squares.maps = variant->maps;
    if (variant->maps != 0 && p->squares.splat.fronts == 0)
        STP_TRY(stp_splat_create(&p->squares.splat, true, folder, defines, err));
    if (p->squares.resolve == 0)
        STP_TRY(stp_program_create(&p->squares.resolve,
                                   &(stp_program_params){.vertex = "screen.vert",
                                                         .fragment = "resolve.frag",
                                                         .defines = defines,
                                                         .folder = folder},
                                   err));
done:
    return status;
}

void stp_project_destroy(stp_project *p)
{
    glDeleteProgram(p->patch_program);
    glDeleteProgram(p->sample_program);
    glDeleteProgram(p->vertex_program);
    stp_scatter_destroy(&p->scatter);
    glDeleteProgram(p->strip_program);
    glDeleteProgram(p->wide_program);
    glDeleteProgram(p->triangle_program);
    stp_runs_destroy(&p->runs);
    stp_squares_destroy(&p->squares);
    stp_splat_destroy(&p->splat);
    if (p->index_buffer != 0)
        glDeleteBuffers(1, &p->index_buffer);
    free(p->indices);
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

/* What the roads that choose on the CPU read about a draw. */
typedef struct seen_draw {
    const stp_resident *resident;
    const uint32_t *patches; /* in sight */
    size_t count;
    stp_gpu_chunk chunk;
} seen_draw;

static seen_draw see(const stp_project_params *params, size_t i)
{
    const stp_sight_list *patches = &params->sight->lists[STP_SIGHT_PATCHES];
    uint32_t slot = stp_block_cache_slot(params->cache, params->draws[i].block);
    return (seen_draw){stp_block_cache_get(params->cache, slot), patches->items + patches->begin[i],
                       patches->begin[i + 1] - patches->begin[i],
                       stp_gpu_chunk_from_draw(params->scene, &params->draws[i], params->eye)};
}

static const stp_mirror_patch *seen_patch(const seen_draw *seen, size_t i)
{
    return &seen->resident->mirror
                .patches[seen->patches[i] - seen->resident->placement.patches.begin];
}

/* Chooses the levels of one block's patches and lists their samples. */
static stp_status list_samples(stp_project *p, const stp_project_params *params,
                               const seen_draw *seen, stp_error *err)
{
    for (size_t i = 0; i < seen->count; i++) {
        const stp_mirror_patch *patch = seen_patch(seen, i);
        stp_range parts[STP_PATCH_QUARTERS];
        stp_levels levels = stp_levels_choose(params->frame, &seen->chunk, patch);
        if (stp_levels_shape(patch, &levels) != 0)
            continue;
        unsigned part_count = stp_levels_select(patch, &levels, parts);
        for (unsigned k = 0; k < part_count; k++) {
            stp_status status = append_run(p, parts[k].begin, parts[k].count, err);
            if (status != STP_OK)
                return status;
        }
    }
    return STP_OK;
}

/* llvmpipe runs vertex and geometry shaders on one thread and its rasteriser on others. A flush
 * hands it a part early: at least FLUSH_POINTS points, in a limited number of parts. It keeps some
 * 300 bytes of each point until the point is rasterised, so at most PARTS_AHEAD parts may wait. */
#define FLUSH_POINTS 2048
#define FLUSH_PARTS 16
#define PARTS_AHEAD 4
#define PART_WAIT_NS UINT64_C(1000000000)

/* Waits for the part drawn PARTS_AHEAD before part i; part i was just drawn. */
static void wait_for_parts(GLsync fences[PARTS_AHEAD], size_t i)
{
    GLsync *fence = &fences[i % PARTS_AHEAD];
    if (*fence != NULL) {
        glClientWaitSync(*fence, 0, PART_WAIT_NS);
        glDeleteSync(*fence);
    }
    *fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
}

/* Draws points with these numbers with the program in use. A frame that does not wait for the GPU
 * does not wait for parts either. */
static void draw_points(stp_project *p, const stp_project_params *params, const uint32_t *items,
                        size_t count)
{
    const GLuint array = stp_block_cache_texture(params->cache)->empty_array;
    GLsync fences[PARTS_AHEAD] = {NULL};
    size_t part = count / FLUSH_PARTS > FLUSH_POINTS ? count / FLUSH_PARTS : FLUSH_POINTS;
    glBindVertexArray(array);
    glNamedBufferData(p->index_buffer, (GLsizeiptr)(count * sizeof *items), items, GL_STREAM_DRAW);
    glVertexArrayElementBuffer(array, p->index_buffer);
    for (size_t i = 0, k = 0; i < count; i += part, k++) {
        glDrawElements(GL_POINTS, (GLsizei)(count - i < part ? count - i : part), GL_UNSIGNED_INT,
                       (const void *)(i * sizeof *items));
        if (params->waits)
            wait_for_parts(fences, k);
        glFlush();
    }
    for (int i = 0; i < PARTS_AHEAD; i++)
        glDeleteSync(fences[i]); /* ignores a fence that is NULL */
}

static void draw_vertices(stp_project *p, const stp_project_params *params)
{
    const stp_sight_list *vertices = &params->sight->lists[STP_SIGHT_VERTICES];
    glUseProgram(p->vertex_program);
    draw_points(p, params, vertices->items, vertices->begin[params->draw_count]);
}

/* Draws the listed patches with a program. */
static void draw_patches(stp_project *p, const stp_project_params *params, GLuint program,
                         stp_sight_kind kind)
{
    const stp_sight_list *patches = &params->sight->lists[kind];
    glUseProgram(program);
    draw_points(p, params, patches->items, patches->begin[params->draw_count]);
}

/* Lists the samples of the chosen levels of all blocks. */
static stp_status list_chosen(stp_project *p, const stp_project_params *params, stp_error *err)
{
    p->index_count = 0;
    for (size_t i = 0; i < params->draw_count; i++) {
        seen_draw seen = see(params, i);
        stp_status status = list_samples(p, params, &seen, err);
        if (status != STP_OK)
            return status;
    }
    return STP_OK;
}

/* Lists every sample of the patches in sight, at their blocks' finest levels. */
static stp_status list_full(stp_project *p, const stp_project_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    p->index_count = 0;
    for (size_t i = 0; i < params->draw_count; i++) {
        const seen_draw seen = see(params, i);
        for (size_t k = 0; k < seen.count; k++) {
            const stp_mirror_patch *patch = seen_patch(&seen, k);
            const int level = stp_level_resident(patch, (int)seen.chunk.finest);
            if (stp_levels_shape(patch, &(stp_levels){{level, level, level, level}}) == 0)
                STP_TRY(
                    append_run(p, stp_name_of(patch->number, level, 0), patch->count[level], err));
        }
    }
done:
    return status;
}

/* Lists the samples, then draws them in one call. */
static stp_status draw_listed(stp_project *p, const stp_project_params *params, uint64_t *points,
                              stp_error *err)
{
    const bool full = params->lod == STP_LOD_FULL;
    stp_status status = full ? list_full(p, params, err) : list_chosen(p, params, err);
    if (status != STP_OK)
        return status;
    glUseProgram(p->sample_program);
    draw_points(p, params, p->indices, p->index_count);
    *points += p->index_count;
    return STP_OK;
}

stp_status stp_project_draw(stp_project *p, const stp_project_params *params, uint64_t *points,
                            stp_error *err)
{
    if (params->lod == STP_LOD_FULL)
        return draw_listed(p, params, points, err);
    if (params->lod == STP_LOD_COMPUTE)
        return stp_scatter_draw(&p->scatter, &p->runs, params, points, err);
    draw_vertices(p, params);
    if (params->lod == STP_LOD_CPU) {
        *points += params->sight->lists[STP_SIGHT_VERTICES].begin[params->draw_count];
        return draw_listed(p, params, points, err);
    }
    draw_patches(p, params, p->patch_program, STP_SIGHT_PATCHES);
    return STP_OK;
}

/* Shapes are drawn between these two. */
static void begin_shapes(const stp_project_params *params)
{
    glScissor(0, 0, params->pyramid->width, params->pyramid->height); /* tiles have set another */
    if (params->frame->modes[2] != 0)                                 /* there is a clip box */
        for (GLenum i = 0; i < 6; i++)
            glEnable(GL_CLIP_DISTANCE0 + i);
}

static void end_shapes(void)
{
    for (GLenum i = 0; i < 6; i++)
        glDisable(GL_CLIP_DISTANCE0 + i);
}

void stp_project_draw_shapes(stp_project *p, const stp_project_params *params)
{
    begin_shapes(params);
    if (p->strip_program != 0)
        draw_patches(p, params, p->strip_program, STP_SIGHT_STRIPS);
    if (p->wide_program != 0)
        draw_patches(p, params, p->wide_program, STP_SIGHT_STRIPS);
    if (p->triangle_program != 0)
        draw_patches(p, params, p->triangle_program, STP_SIGHT_TRIANGLES);
    end_shapes();
}

stp_status stp_project_draw_squares(stp_project *p, const stp_project_params *params,
                                    uint64_t *points, stp_error *err)
{
    stp_squares *s = &p->squares;
    stp_status status = STP_OK;
    STP_TRY(stp_squares_list(s, params, points, err));
    begin_shapes(params);
    stp_squares_draw(s, params);
    end_shapes();
    if (s->count > s->triangles) {
        const stp_range maps = {(uint32_t)s->triangles, (uint32_t)(s->count - s->triangles)};
        STP_TRY(stp_splat_list_squares(&s->splat, maps, params->pyramid, err));
        glProgramUniform1i(s->splat.fronts, STP_UNIFORM_SCATTERED, params->lod == STP_LOD_COMPUTE);
        stp_splat_draw_fronts(&s->splat, params->tiles);
        if (s->maps == STP_MAPS_BLEND)
            stp_splat_bind(&s->splat, s->resolve);
    }
done:
    return status;
}

/* Lists the samples that the CPU chooses, and the patch vertices listed apart. */
static stp_status list_all(stp_project *p, const stp_project_params *params, uint64_t *points,
                           stp_error *err)
{
    stp_status status = STP_OK;
    const stp_sight_list *vertices = &params->sight->lists[STP_SIGHT_VERTICES];
    STP_TRY(params->lod == STP_LOD_FULL ? list_full(p, params, err) : list_chosen(p, params, err));
    for (size_t i = 0; i < vertices->begin[params->draw_count]; i++)
        STP_TRY(append_run(p, vertices->items[i], 1, err));
    *points += p->index_count;
done:
    return status;
}

stp_status stp_project_list(stp_project *p, const stp_project_params *params, uint64_t *points,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const stp_sight_list *vertices = &params->sight->lists[STP_SIGHT_VERTICES];
    if (params->lod == STP_LOD_CPU || params->lod == STP_LOD_FULL) {
        STP_TRY(list_all(p, params, points, err));
        stp_runs_take(&p->runs, p->indices, p->index_count);
    } else {
        stp_runs_choose(&p->runs, params, vertices->items, vertices->begin[params->draw_count],
                        true, points);
        stp_stage_end(params->clock, STP_STAGE_CHOOSE);
    }
    STP_TRY(stp_splat_list(&p->splat, &p->runs, params->pyramid, err));
done:
    return status;
}
