/* Which level of each quarter of a patch the geometry shader really draws.
 *
 * The renderer runs with its own patch.geom and choose.glsl; only what comes after is replaced:
 * every sample it emits falls on one pixel, and the fragment counts it in a buffer instead of being
 * drawn. Failures end the test. */
#ifndef STP_TESTS_GL_LEVELS_H
#define STP_TESTS_GL_LEVELS_H

#include "runtime/shader.h"
#include "tests/gl_fixture.h"
#include "tests/scan_fixture.h"

#include <sys/stat.h>

typedef struct gl_levels {
    gl_fixture fixture;
    GLuint buffer;
    uint32_t *noted; /* how often each sample of the Object Texture was emitted */
    size_t capacity;
} gl_levels;

#define GL_LEVELS_FOLDER "noting-shaders"

/* Writes the shaders that note. */
static inline void gl_levels_shaders(void)
{
    static const char note[] =
        "flat in uint id;\n"
        "layout(location = 0) out uint nearest;\n"
        "layout(std430, binding = 0) buffer noted_buffer { uint noted[]; };\n"
        "void main()\n{\n"
        "    atomicAdd(noted[id], 1u);\n"
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
    levels->capacity = stp_chunk_cache_texture(look.cache)->sample_ranges.capacity;
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

/* Draws a view by the geometry shader and fills noted. */
static inline void gl_levels_draw(gl_levels *levels, const stp_view *view,
                                  const stp_draw_params *params)
{
    memset(levels->noted, 0, levels->capacity * sizeof *levels->noted);
    GLsizeiptr bytes = (GLsizeiptr)(levels->capacity * sizeof *levels->noted);
    glNamedBufferSubData(levels->buffer, 0, bytes, levels->noted);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, levels->buffer);
    stp_draw_stats stats;
    stp_draw_params by_shader = *params;
    by_shader.lod = STP_LOD_GEOMETRY;
    check_ok(stp_renderer_draw(levels->fixture.renderer, view, &by_shader, &stats, err));
    assert_true(stats.cut_complete);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(levels->buffer, 0, bytes, levels->noted);
    check_ok(stp_gl_check("noting levels", err));
}

/* The samples of [begin, end) are all emitted once, or none is. */
static inline bool gl_levels_emitted(const gl_levels *levels, uint32_t begin, uint32_t end)
{
    for (uint32_t i = begin; i < end; i++)
        if (levels->noted[i] != levels->noted[begin] || levels->noted[i] > 1)
            fail_msg("sample %u is emitted %u times, its like %u", i, levels->noted[i],
                     levels->noted[begin]);
    return begin < end && levels->noted[begin] == 1;
}

/* The levels drawn of patch p of a resident chunk; what is emitted must be exactly one level of
 * each quarter, or level 3, or nothing. */
static inline stp_levels gl_levels_drawn(const gl_levels *levels, const stp_resident *resident,
                                         uint32_t p)
{
    const stp_gpu_patch *patch = &resident->patches[p];
    stp_levels drawn;
    unsigned parts = 0;
    memset(&drawn, STP_LEVEL_SKIP, sizeof drawn);
    bool whole = gl_levels_emitted(levels, patch->first[3], patch->first[3] + 1);
    if (whole)
        drawn.of[0] = 3;
    for (unsigned q = 0; q < patch->count[2]; q++)
        for (int level = 2; level >= 0 && patch->count[level] > 0; level--) {
            uint32_t begin = patch->first[level] + stp_quarter_begin(patch->count, level, q);
            uint32_t end = patch->first[level] + stp_quarter_begin(patch->count, level, q + 1);
            if (!gl_levels_emitted(levels, begin, end))
                continue;
            if (whole || drawn.of[q] != STP_LEVEL_SKIP)
                fail_msg("patch %u of chunk %u, quarter %u is drawn twice", p, resident->chunk, q);
            drawn.of[q] = level;
            parts++;
        }
    if (parts != 0 && parts != patch->count[2])
        fail_msg("patch %u of chunk %u: %u of %u quarters are drawn", p, resident->chunk, parts,
                 patch->count[2]);
    return drawn;
}

#endif
