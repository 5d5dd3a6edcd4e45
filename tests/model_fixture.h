/* Known surfaces as chunk files, made by the library as `stipple gen` and `stipple prep` make them,
 * and as true meshes. Failures end the test. */
#ifndef STP_TESTS_MODEL_FIXTURE_H
#define STP_TESTS_MODEL_FIXTURE_H

#include "base/pool.h"
#include "preprocess/prep.h"
#include "tests/support/check.h"
#include "tests/support/triangles.h"
#include "tools/gen/sampler.h"
#include "tools/gen/surface.h"

typedef struct model_recipe {
    gen_shape shape;
    uint64_t point_count;
    double noise_spacings;
    bool true_normals; /* else they are estimated and oriented */
    stp_orient_mode orient;
    double lambda;
} model_recipe;

typedef struct model_stream {
    const gen_sampler *sampler;
    uint64_t next, end;
    bool normals;
} model_stream;

static inline stp_status model_stream_read(void *context, stp_point *points, size_t capacity,
                                           size_t *count, stp_error *err)
{
    (void)err;
    model_stream *stream = context;
    uint64_t left = stream->end - stream->next;
    *count = left < capacity ? (size_t)left : capacity;
    if (*count > 0)
        gen_sampler_fill(stream->sampler, stream->next, *count, points, NULL);
    for (size_t i = 0; i < *count && !stream->normals; i++)
        points[i].normal = (vec3s){{0.0f, 0.0f, 0.0f}};
    stream->next += *count;
    return STP_OK;
}

/* Writes the recipe's model; returns the spacing of its samples. */
static inline double model_fixture_build(const char *path, const model_recipe *recipe)
{
    stp_pool *pool = NULL;
    gen_sampler *sampler = NULL;
    gen_surface surface;
    stp_prep_stats stats;
    check_ok(stp_pool_create(&pool, 2, err));
    gen_surface_init(&surface, recipe->shape, recipe->point_count, 0);
    gen_sampler_params params = {.surface = &surface,
                                 .point_count = recipe->point_count,
                                 .noise_spacings = recipe->noise_spacings};
    check_ok(gen_sampler_create(&sampler, &params, pool, err));
    model_stream stream = {sampler, 0, recipe->point_count, recipe->true_normals};
    const stp_prep_file file = {.name = "a known surface"};
    stp_prep_source source = {.context = &stream,
                              .read = model_stream_read,
                              .point_count = recipe->point_count,
                              .attributes = STP_POINT_HAS_COLOUR |
                                            (recipe->true_normals ? STP_POINT_HAS_NORMAL : 0u),
                              .files = &file,
                              .file_count = 1};
    stp_prep_params prep = {.orient = recipe->orient,
                            .lambda = recipe->lambda,
                            .codec = STP_CODEC_DRACO,
                            .force = true};
    check_ok(stp_prep_run(path, &source, &prep, pool, NULL, &stats, err));
    assert_int_equal(stats.points_out, recipe->point_count);
    double spacing = gen_sampler_spacing(sampler);
    gen_sampler_destroy(&sampler);
    stp_pool_destroy(&pool);
    return spacing;
}

/* The true surface as about so many triangles (0: as many as `stipple gen --mesh` makes); free with
 * model_fixture_mesh_clear. */
static inline triangles_mesh model_fixture_mesh(gen_shape shape, uint64_t point_count,
                                                uint64_t triangle_count)
{
    stp_pool *pool = NULL;
    gen_surface surface;
    gen_mesh mesh = {0};
    check_ok(stp_pool_create(&pool, 2, err));
    gen_surface_init(&surface, shape, point_count, 0);
    triangle_count = triangle_count > 0 ? triangle_count : surface.mesh_triangles;
    check_ok(surface.mesh(&surface, triangle_count, pool, &mesh, err));
    stp_pool_destroy(&pool);
    stp_dvec3 *positions = calloc(mesh.vertex_count, sizeof *positions);
    assert_non_null(positions);
    for (size_t i = 0; i < mesh.vertex_count; i++)
        positions[i] = stp_dvec3_from_float(mesh.positions[i]);
    free(mesh.positions);
    return (triangles_mesh){mesh.vertex_count, mesh.triangle_count, positions, NULL,
                            (const uint32_t(*)[3])mesh.triangles};
}

static inline void model_fixture_mesh_clear(triangles_mesh *mesh)
{
    free((void *)(uintptr_t)mesh->positions);
    free((void *)(uintptr_t)mesh->triangles);
    *mesh = (triangles_mesh){0};
}

#endif
