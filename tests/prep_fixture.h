/* What the tests of preprocessing share: points in memory through prep, and files read back.
 * Every point carries a number in its colour (24 bits) and class (8 bits), which level 0 keeps. */
#ifndef STP_TESTS_PREP_FIXTURE_H
#define STP_TESTS_PREP_FIXTURE_H

#include "base/random.h"
#include "formats/chunk/verify.h"
#include "preprocess/prep.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct prep_cloud {
    stp_point *points;
    size_t count, given;
} prep_cloud;

static inline void prep_number(stp_point *p, uint32_t number)
{
    for (int c = 0; c < 3; c++)
        p->rgb[c] = (uint16_t)((number >> 8 * c & 255u) * 257u);
    p->class_id = (uint8_t)(number >> 24);
}

static inline uint32_t prep_number_of(const stp_sample *s)
{
    return (uint32_t)s->rgb[0] | (uint32_t)s->rgb[1] << 8 | (uint32_t)s->rgb[2] << 16 |
           (uint32_t)s->class_id << 24;
}

/* count points numbered in order, at the origin. */
static inline prep_cloud prep_cloud_make(size_t count)
{
    prep_cloud out = {calloc(count + 1, sizeof(stp_point)), count, 0};
    assert_non_null(out.points);
    for (size_t i = 0; i < count; i++)
        prep_number(&out.points[i], (uint32_t)i);
    return out;
}

/* A wavy closed surface around a centre, in random order. */
static inline prep_cloud prep_cloud_wavy(size_t count, stp_dvec3 centre, double size)
{
    prep_cloud out = prep_cloud_make(count);
    for (size_t i = 0; i < count; i++) {
        double z = 2.0 * stp_random_unit(1, i) - 1.0;
        double a = 2.0 * M_PI * stp_random_unit(2, i);
        double r = size * (1.0 + 0.1 * sin(9.0 * z) * cos(5.0 * a));
        double across = sqrt(1.0 - z * z) * r;
        stp_dvec3 p = {across * cos(a), across * sin(a), r * z};
        out.points[i].position = stp_dvec3_add(centre, p);
        out.points[i].intensity = (uint16_t)(i % 256 * 257);
    }
    return out;
}

static inline stp_status prep_cloud_read(void *context, stp_point *points, size_t capacity,
                                         size_t *count, stp_error *err)
{
    prep_cloud *c = context;
    (void)err;
    *count = c->count - c->given < capacity ? c->count - c->given : capacity;
    if (*count > 0)
        memcpy(points, c->points + c->given, *count * sizeof *points);
    c->given += *count;
    return STP_OK;
}

/* Preprocesses points, lines and triangles, each NULL for none, into a file. */
static inline stp_status prep_shapes_run(prep_cloud *points, const stp_line_set *lines,
                                         const stp_triangle_set *triangles, const char *path,
                                         unsigned threads, const stp_prep_params *params,
                                         stp_prep_stats *stats, stp_error *err)
{
    stp_prep_params own = params ? *params : (stp_prep_params){0};
    prep_cloud none = {0}, *cloud = points ? points : &none;
    const stp_prep_file file = {.name = "a known surface"};
    stp_prep_source source = {.context = cloud,
                              .read = prep_cloud_read,
                              .point_count = cloud->count,
                              .attributes = STP_POINT_HAS_COLOUR | STP_POINT_HAS_CLASS |
                                            STP_POINT_HAS_INTENSITY,
                              .lines = lines,
                              .triangles = triangles,
                              .files = &file,
                              .file_count = 1};
    stp_pool *pool = NULL;
    if (cloud->count > 0 && cloud->points[0].normal.z != 0.0f) /* of all or of none */
        source.attributes |= STP_POINT_HAS_NORMAL;
    cloud->given = 0;
    own.force = true;
    assert_int_equal(stp_pool_create(&pool, threads, err), STP_OK);
    stp_status status = stp_prep_run(path, &source, &own, pool, NULL, stats, err);
    stp_pool_destroy(&pool);
    return status;
}

/* Preprocesses the cloud into a file. */
static inline stp_status prep_cloud_run(prep_cloud *cloud, const char *path, unsigned threads,
                                        const stp_prep_params *params, stp_prep_stats *stats,
                                        stp_error *err)
{
    return prep_shapes_run(cloud, NULL, NULL, path, threads, params, stats, err);
}

/* All bytes of a file: free() them. */
static inline uint8_t *prep_file_bytes(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    *size = (size_t)ftell(file);
    rewind(file);
    uint8_t *bytes = malloc(*size);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *size, file), *size);
    fclose(file);
    return bytes;
}

/* Opens a file, of what is named, after everything it promises has been checked. */
static inline stp_chunk_file *prep_open_verified_of(const char *path, const char *what)
{
    stp_error err = {0};
    stp_chunk_file *file = NULL;
    stp_pool *pool = NULL;
    assert_int_equal(stp_pool_create(&pool, 2, &err), STP_OK);
    if (stp_chunk_file_open(&file, path, &err) != STP_OK ||
        stp_chunk_file_verify(file, pool, NULL, &err) != STP_OK)
        fail_msg("%s: %s", what, err.message);
    stp_pool_destroy(&pool);
    return file;
}

static inline stp_chunk_file *prep_open_verified(const char *path)
{
    return prep_open_verified_of(path, path);
}

static inline stp_chunk *prep_chunk(stp_chunk_file *file, uint32_t id, stp_chunk_entry *entry)
{
    stp_error err = {0};
    stp_chunk *chunk = NULL;
    if (stp_chunk_file_entry(file, id, entry, &err) != STP_OK ||
        stp_chunk_file_read(file, id, 0, &chunk, &err) != STP_OK)
        fail_msg("%s", err.message);
    return chunk;
}

typedef void prep_visitor(void *context, const stp_chunk_entry *entry, const stp_patch *patch,
                          const stp_sample *sample);

/* All points: level 0 of the leaves. */
static inline void prep_visit_points(stp_chunk_file *file, prep_visitor *visit, void *context)
{
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        for (uint32_t p = 0; entry.child_count == 0 && p < chunk->patch_count; p++)
            for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++)
                visit(context, &entry, &chunk->patches[p], &chunk->samples[0][i]);
        stp_chunk_destroy(&chunk);
    }
}

#endif
