/* What the tests with a renderer share: a context or a skip, a model drawn, and what was drawn as
 * the CPU sees it. Failures end the test. */
#ifndef STP_TESTS_GL_FIXTURE_H
#define STP_TESTS_GL_FIXTURE_H

#include "runtime/gl_context.h"
#include "runtime/inspect.h"
#include "runtime/project.h"
#include "runtime/stipple.h"
#include "tests/drawn_discs.h"
#include "tests/support/check.h"
#include "tests/support/promise.h"
#include "tests/support/reference.h"

#include <math.h>

typedef struct gl_fixture {
    stp_model *model;
    stp_renderer *renderer;
} gl_fixture;

/* The context, or the end of the program by exit 77 where there is none. */
static inline stp_gl_context *gl_fixture_context(void)
{
    stp_gl_context *context = NULL;
    stp_error error = {0};
    stp_status status = stp_gl_context_create(&context, &error);
    if (status == STP_OK)
        status = stp_gl_context_check(&error);
    if (status != STP_OK) {
        printf("skipped: %s\n", error.message);
        exit(77);
    }
    return context;
}

static inline void gl_fixture_open(gl_fixture *f, const char *path, const char *shader_folder)
{
    check_ok(stp_model_open(&f->model, path, err));
    stp_renderer_params params = {
        .model = f->model, .thread_count = 2, .shader_folder = shader_folder};
    check_ok(stp_renderer_create(&f->renderer, &params, err));
}

static inline void gl_fixture_close(gl_fixture *f)
{
    stp_renderer_destroy(&f->renderer);
    stp_model_close(&f->model);
}

/* Draws and reads, waiting for the whole cut unless chunks stream; stats: NULL if not wanted. */
static inline void gl_fixture_draw(const gl_fixture *f, const stp_view *view,
                                   const stp_draw_params *params, stp_draw_stats *stats,
                                   uint8_t *rgba)
{
    stp_draw_stats own = {0};
    stp_draw_stats *drawn = stats != NULL ? stats : &own;
    check_ok(stp_renderer_draw(f->renderer, view, params, drawn, err));
    assert_true(drawn->cut_complete || params->stream);
    check_ok(stp_renderer_read(f->renderer, rgba, err));
}

/* Pixels that anything covers. */
static inline size_t gl_fixture_covered(const uint8_t *rgba, size_t pixels)
{
    size_t count = 0;
    for (size_t i = 0; i < pixels; i++)
        count += rgba[4 * i + 3] != 0;
    return count;
}

/* ---- what was chosen, by the CPU ---- */

/* Patches and level of every patch of the last frame's draw i. */
static inline const stp_resident *gl_fixture_resident(const gl_fixture *f, size_t i,
                                                      stp_gpu_chunk *chunk)
{
    stp_inspection look = stp_renderer_inspect(f->renderer);
    const stp_draw *draw = &look.cut->draws[i];
    *chunk = stp_gpu_chunk_from_draw(&f->model->entries[draw->chunk], draw, look.eye);
    return stp_chunk_cache_get(look.cache, stp_chunk_cache_slot(look.cache, draw->chunk));
}

/* The samples of one drawn chunk, in the order they are drawn, appended to discs. splat: as of
 * gl_fixture_append_samples. */
static inline void gl_fixture_append(const gl_fixture *f, size_t draw, const stp_view *view,
                                     bool splat, reference_disc_list *discs)
{
    stp_gpu_chunk record;
    stp_chunk *chunk = NULL;
    const stp_resident *resident = gl_fixture_resident(f, draw, &record);
    stp_inspection look = stp_renderer_inspect(f->renderer);
    const stp_chunk_entry *entry = &f->model->entries[record.id];
    check_ok(stp_chunk_file_read(f->model->file, record.id, 0, &chunk, err));
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_gpu_patch *patch = &resident->patches[p];
        if (!stp_patch_in_sight(look.sight, &look.looked, &look.cut->draws[draw], resident->briefs,
                                p))
            continue;
        const drawn_patch drawn = {entry, chunk, p, patch,
                                   stp_levels_choose(look.frame, &record, patch)};
        check_ok(drawn_append(&drawn, view, look.frame, splat, discs, err));
    }
    stp_chunk_destroy(&chunk);
}

/* All samples of the last frame. */
static inline reference_disc_list gl_fixture_discs(const gl_fixture *f, const stp_view *view,
                                                   bool splat)
{
    reference_disc_list discs = {0};
    stp_inspection look = stp_renderer_inspect(f->renderer);
    for (size_t i = 0; i < look.cut->draw_count; i++)
        gl_fixture_append(f, i, view, splat, &discs);
    return discs;
}

/* ---- what the GPU made of it ---- */

static inline double gl_fixture_snorm(uint32_t bits)
{
    return fmax(-1.0, (double)(int16_t)(uint16_t)bits / 32767.0);
}

static inline double gl_fixture_float(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

/* A pixel out of its texels (shaders/pixel.glsl). */
static inline reference_pixel gl_fixture_pixel(const uint32_t shape[4], const uint32_t paint[4])
{
    reference_pixel p = {.tag = (int)(paint[3] >> 16)};
    if (p.tag == 0)
        return p;
    double x = gl_fixture_snorm(paint[0]), y = gl_fixture_snorm(paint[0] >> 16);
    stp_dvec3 n = {x, y, 1.0 - fabs(x) - fabs(y)};
    if (n.z < 0.0) {
        n.x = (1.0 - fabs(y)) * (x >= 0.0 ? 1.0 : -1.0);
        n.y = (1.0 - fabs(x)) * (y >= 0.0 ? 1.0 : -1.0);
    }
    p.normal = stp_dvec3_normalize(n);
    p.radius = gl_fixture_float(shape[2]);
    p.z_min = gl_fixture_float(paint[1]);
    p.z_max = gl_fixture_float(shape[3]);
    p.dx = gl_fixture_float(shape[0]);
    p.dy = gl_fixture_float(shape[1]);
    p.rgb[0] = (paint[2] & 65535u) / 65535.0;
    p.rgb[1] = (paint[2] >> 16) / 65535.0;
    p.rgb[2] = (paint[3] & 65535u) / 65535.0;
    return p;
}

/* A level of the last frame as pulled or finished; free with free(). */
static inline reference_pixel *gl_fixture_level(const gl_fixture *f, int l, bool finished)
{
    const stp_pyramid *pyramid = stp_renderer_inspect(f->renderer).pyramid;
    const stp_pyramid_level *level = &pyramid->levels[l];
    const GLuint *textures = finished ? stp_pyramid_finished(pyramid, l) : level->pulled;
    size_t count = (size_t)level->width * (size_t)level->height;
    uint32_t(*texels[2])[4];
    for (int i = 0; i < 2; i++) {
        texels[i] = calloc(count, sizeof *texels[i]);
        assert_non_null(texels[i]);
        glGetTextureSubImage(textures[i], 0, 0, 0, 0, level->width, level->height, 1,
                             GL_RGBA_INTEGER, GL_UNSIGNED_INT, (GLsizei)(count * sizeof *texels[i]),
                             texels[i]);
    }
    check_ok(stp_gl_check("reading pixels", err));
    reference_pixel *pixels = calloc(count, sizeof *pixels);
    assert_non_null(pixels);
    for (size_t i = 0; i < count; i++)
        pixels[i] = gl_fixture_pixel(texels[0][i], texels[1][i]);
    free(texels[0]);
    free(texels[1]);
    return pixels;
}

/* Level 0 of the last frame as pulled or (where drawn with keep_pixels) as finished; free with
 * free(). */
static inline reference_pixel *gl_fixture_pixels(const gl_fixture *f, bool finished)
{
    return gl_fixture_level(f, 0, finished);
}

/* The picture's alpha as a mask, bottom row first; free with free(). */
static inline uint8_t *gl_fixture_mask(gl_fixture *f, const stp_view *view)
{
    size_t count = (size_t)view->width * (size_t)view->height;
    uint8_t *rgba = calloc(count, 4);
    assert_non_null(rgba);
    check_ok(stp_renderer_read(f->renderer, rgba, err));
    for (size_t i = 0; i < count; i++)
        rgba[i] = rgba[4 * i + 3];
    return rgba;
}

#endif
