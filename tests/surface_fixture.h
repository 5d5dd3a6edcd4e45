/* A known surface sampled and taken through the stages of preprocessing up to orientation. */
#ifndef STP_TESTS_SURFACE_FIXTURE_H
#define STP_TESTS_SURFACE_FIXTURE_H

#include "preprocess/orientation.h"
#include "preprocess/surface.h"
#include "tools/gen/sampler.h"
#include "tools/gen/visibility.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>

typedef struct surface_cloud {
    stp_cloud cloud;
    unsigned k;
    gen_hit *truth; /* by source */
    stp_dvec3 stations[GEN_STATION_LIMIT];
    stp_orientation orientation;
    stp_pool *pool;
} surface_cloud;

/* Sorts the points, finds spacings and normals as prep does; cloud.points is given with positions
 * and stations alone. */
static inline void surface_prepare(surface_cloud *s, unsigned k)
{
    stp_error err = {0};
    stp_graph *none = NULL;
    const stp_surface_params params = {.k = k};
    s->k = k;
    assert_int_equal(stp_pool_create(&s->pool, 2, &err), STP_OK);
    assert_int_equal(stp_cloud_sort(&s->cloud, s->pool, &err), STP_OK);
    assert_int_equal(stp_surface_find(&none, &s->cloud, &params, NULL, s->pool, NULL, &err),
                     STP_OK);
}

/* As scanned from so many stations around; 0: all of it, from none. */
static inline surface_cloud surface_scan(gen_shape shape, uint32_t count, double noise,
                                         unsigned station_count)
{
    surface_cloud s = {0};
    gen_surface surface;
    gen_sampler *sampler = NULL;
    stp_pool *pool = NULL;
    stp_error err = {0};
    stp_point *points = calloc(count, sizeof *points);
    s.truth = calloc(count, sizeof *s.truth);
    s.cloud.points = calloc(count, sizeof *s.cloud.points);
    assert_true(points && s.truth && s.cloud.points);
    s.cloud.capacity = count;
    gen_surface_init(&surface, shape, count, 1);
    gen_sampler_params params = {.surface = &surface,
                                 .point_count = count,
                                 .seed = 1,
                                 .station_count = station_count,
                                 .noise_spacings = noise,
                                 .random_order = true};
    assert_int_equal(stp_pool_create(&pool, 2, &err), STP_OK);
    assert_int_equal(gen_sampler_create(&sampler, &params, pool, &err), STP_OK);
    gen_sampler_fill(sampler, 0, count, points, s.truth);
    for (unsigned i = 0; i < station_count; i++)
        s.stations[i] = gen_sampler_stations(sampler)[i];
    s.cloud.count = count;
    for (uint32_t i = 0; i < count; i++)
        s.cloud.points[i] = (stp_cloud_point){
            .position = points[i].position, .source = i, .station = points[i].station};
    gen_sampler_destroy(&sampler);
    stp_pool_destroy(&pool);
    free(points);
    return s;
}

/* Keeps the points that face a scanner. */
static inline void surface_keep_facing(surface_cloud *s, stp_dvec3 scanner)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < s->cloud.count; i++) {
        const gen_hit *hit = &s->truth[s->cloud.points[i].source];
        if (stp_dvec3_dot(stp_dvec3_from_float(hit->normal),
                          stp_dvec3_sub(scanner, hit->position)) > 0.0)
            s->cloud.points[kept++] = s->cloud.points[i];
    }
    s->cloud.count = kept;
}

/* After surface_prepare; may be called again. */
static inline void surface_orient(surface_cloud *s, stp_orient_params params)
{
    stp_error err = {0};
    stp_graph *graphs = NULL;
    const stp_surface_params surface = {.k = s->k,
                                        .pieces = !stp_orient_by_file(&params),
                                        .stations = stp_orient_stations(&params)};
    for (uint32_t i = 0; params.mode == STP_ORIENT_POSITION && i < s->cloud.count; i++)
        s->cloud.points[i].station = 1;
    assert_int_equal(stp_surface_find(&graphs, &s->cloud, &surface, NULL, s->pool, NULL, &err),
                     STP_OK);
    assert_int_equal(
        stp_orientation_find(&s->cloud, s->k, &graphs, &params, s->pool, &s->orientation, &err),
        STP_OK);
}

static inline bool surface_is_oriented(const surface_cloud *s, uint32_t i)
{
    return s->cloud.marks[i] & STP_MARK_ORIENTED;
}

static inline void surface_clear(surface_cloud *s)
{
    stp_cloud_clear(&s->cloud);
    stp_pool_destroy(&s->pool);
    free(s->truth);
}

/* Mean angle to the true normals in degrees, signs apart. */
static inline double surface_mean_error(const surface_cloud *s)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < s->cloud.count; i++) {
        const stp_cloud_point *p = &s->cloud.points[i];
        double cosine = fabs((double)glms_vec3_dot(p->normal, s->truth[p->source].normal));
        sum += acos(fmin(1.0, cosine)) * 180.0 / M_PI;
    }
    return sum / s->cloud.count;
}

#endif
