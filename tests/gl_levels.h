/* Which level of each patch the geometry shader really draws.
 *
 * The renderer runs with its own patch.geom and choose.glsl; only what comes after is replaced:
 * every sample it emits falls on one pixel, and the fragment notes which patch it came from in a
 * buffer instead of being drawn. Failures end the test. */
#ifndef STP_TESTS_GL_LEVELS_H
#define STP_TESTS_GL_LEVELS_H

#include "runtime/shader.h"
#include "tests/gl_fixture.h"
#include "tests/scan_fixture.h"

#include <sys/stat.h>

/* Samples emitted of a patch, and the least index of them in the Object Texture. */
typedef struct gl_noted {
    uint32_t count, first;
} gl_noted;

typedef struct gl_levels {
    gl_fixture fixture;
    GLuint buffer;
    gl_noted *noted; /* by patch index on the GPU */
    size_t capacity;
} gl_levels;

#define GL_LEVELS_FOLDER "noting-shaders"

/* Writes the shaders that note. */
static inline void gl_levels_shaders(void)
{
    static const char note[] =
        "flat in uint id;\n"
        "layout(location = 0) out uint nearest;\n"
        "layout(binding = 3) uniform usamplerBuffer patch_of_sample;\n"
        "layout(std430, binding = 0) buffer noted_buffer { uvec2 noted[]; };\n"
        "void main()\n{\n"
        "    uint p = texelFetch(patch_of_sample, int(id)).x;\n"
        "    atomicAdd(noted[p].x, 1u);\n"
        "    atomicMin(noted[p].y, id);\n"
        "    nearest = id;\n}\n";
    static const char name[] = "vec4 stp_project(";
    static char text[1 << 16];
    const stp_shader_file *file = stp_shader_files;
    while (file->name != NULL && strcmp(file->name, "project.glsl") != 0)
        file++;
    assert_non_null(file->name);
    const char *begin = strstr(file->text, name);
    assert_non_null(begin);
    const char *parameters = begin + strlen(name);
    /* The function as ever under another name, and one of its kind that drops nothing. */
    snprintf(text, sizeof text,
             "%.*svec4 stp_project_as_ever(%s\n"
             "%s%.*s)\n{\n    return vec4(0.0, 0.0, 0.5, 1.0);\n}\n",
             (int)(begin - file->text), file->text, parameters, name, (int)strcspn(parameters, ")"),
             parameters);
    mkdir(GL_LEVELS_FOLDER, 0777);
    scan_fixture_text(GL_LEVELS_FOLDER "/project.glsl", text);
    scan_fixture_text(GL_LEVELS_FOLDER "/id.frag", note);
}

static inline void gl_levels_open(gl_levels *levels, const char *path)
{
    gl_levels_shaders();
    gl_fixture_open(&levels->fixture, path, GL_LEVELS_FOLDER);
    stp_inspection look = stp_renderer_inspect(levels->fixture.renderer);
    levels->capacity = stp_chunk_cache_texture(look.cache)->patch_ranges.capacity;
    levels->noted = calloc(levels->capacity, sizeof *levels->noted);
    assert_non_null(levels->noted);
    glCreateBuffers(1, &levels->buffer);
    glNamedBufferStorage(levels->buffer, (GLsizeiptr)(levels->capacity * sizeof *levels->noted),
                         NULL, GL_DYNAMIC_STORAGE_BIT);
}

static inline void gl_levels_close(gl_levels *levels)
{
    glDeleteBuffers(1, &levels->buffer);
    free(levels->noted);
    gl_fixture_close(&levels->fixture);
}

/* Draws a view and fills noted. */
static inline void gl_levels_draw(gl_levels *levels, const stp_view *view,
                                  const stp_draw_params *params)
{
    for (size_t i = 0; i < levels->capacity; i++)
        levels->noted[i] = (gl_noted){0, UINT32_MAX};
    GLsizeiptr bytes = (GLsizeiptr)(levels->capacity * sizeof *levels->noted);
    glNamedBufferSubData(levels->buffer, 0, bytes, levels->noted);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, levels->buffer);
    stp_draw_stats stats;
    check_ok(stp_renderer_draw(levels->fixture.renderer, view, params, &stats, err));
    assert_true(stats.cut_complete);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(levels->buffer, 0, bytes, levels->noted);
    check_ok(stp_gl_check("noting levels", err));
}

/* The level drawn of patch p of a resident chunk, or STP_LEVEL_SKIP; the samples must be exactly
 * those of one level. */
static inline int gl_levels_drawn(const gl_levels *levels, const stp_resident *resident, uint32_t p)
{
    const gl_noted *noted = &levels->noted[resident->placement.patches.begin + p];
    const stp_gpu_patch *patch = &resident->patches[p];
    if (noted->count == 0)
        return STP_LEVEL_SKIP;
    for (int level = 0; level < STP_LEVEL_COUNT; level++)
        if (noted->first == patch->first[level] && noted->count == patch->count[level])
            return level;
    fail_msg("patch %u of chunk %u: %u samples from %u on are no level", p, resident->chunk,
             noted->count, noted->first);
    return STP_LEVEL_COUNT;
}

#endif
