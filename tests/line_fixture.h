/* What the tests of lines and triangles share: known ones, through prep into files, and read back.
 * Each vertex has its number in its colour and class, which level 0 keeps. */
#ifndef STP_TESTS_LINE_FIXTURE_H
#define STP_TESTS_LINE_FIXTURE_H

#include "tests/prep_fixture.h"

static inline stp_line_set line_set_make(uint64_t vertex_count, uint64_t strip_count)
{
    stp_line_set out = {calloc(vertex_count + 1, sizeof(stp_line_vertex)), vertex_count,
                        calloc(strip_count + 1, sizeof(stp_line_strip)), strip_count};
    assert_non_null(out.vertices);
    assert_non_null(out.strips);
    for (uint64_t i = 0; i < vertex_count; i++) {
        for (int c = 0; c < 3; c++)
            out.vertices[i].rgb[c] = (uint16_t)((i >> 8 * c & 255u) * 257u);
        out.vertices[i].class_id = (uint8_t)(i >> 24);
        out.vertices[i].intensity = 65535;
    }
    return out;
}

/* Wound around a middle axis, of changing width, every strip a piece of its own. */
static inline stp_line_set line_set_helices(uint64_t strip_count, uint64_t each, stp_dvec3 at,
                                            double size, double radius, stp_line_kind kind)
{
    stp_line_set out = line_set_make(strip_count * each, strip_count);
    for (uint64_t s = 0; s < strip_count; s++) {
        stp_dvec3 middle = {size * 4.0 * stp_random_unit(3, s), size * 4.0 * stp_random_unit(4, s),
                            size * 4.0 * stp_random_unit(5, s)};
        out.strips[s] = (stp_line_strip){s * each, each, kind};
        for (uint64_t i = 0; i < each; i++) {
            double t = 0.05 * (double)i, w = 1.0 + 0.2 * sin(0.3 * (double)i);
            stp_dvec3 p = {size * cos(t) * w, size * sin(t), 0.1 * size * t};
            stp_line_vertex *v = &out.vertices[s * each + i];
            v->position = stp_dvec3_add(at, stp_dvec3_add(middle, p));
            v->radius = (float)(radius * (1.0 + 0.5 * sin(0.7 * (double)i)));
            if (kind == STP_LINE_RIBBON)
                v->direction = (vec3s){{(float)cos(t), (float)sin(t), 0.0f}};
        }
    }
    return out;
}

/* A wavy grid of n x n cells whose size grows along x; every vertex has its number. */
static inline stp_triangle_set triangle_set_grid(uint32_t n, stp_dvec3 at)
{
    stp_line_set numbered = line_set_make((uint64_t)(n + 1) * (n + 1), 0);
    stp_triangle_set out = {.vertices = numbered.vertices, .vertex_count = numbered.vertex_count};
    free(numbered.strips);
    out.triangles = calloc(2 * (size_t)n * n, sizeof *out.triangles);
    assert_non_null(out.triangles);
    for (uint32_t y = 0; y <= n; y++)
        for (uint32_t x = 0; x <= n; x++) {
            double u = pow((double)x / n, 3.0) * 10.0, v = 10.0 * y / n;
            out.vertices[y * (n + 1) + x].position =
                stp_dvec3_add(at, (stp_dvec3){u, v, 0.3 * sin(2.0 * u) * cos(v)});
        }
    for (uint32_t y = 0; y < n; y++)
        for (uint32_t x = 0; x < n; x++) {
            const uint32_t a = y * (n + 1) + x, b = a + n + 1;
            const uint32_t two[2][3] = {{a, a + 1, b}, {a + 1, b + 1, b}};
            memcpy(out.triangles[out.triangle_count], two, sizeof two);
            out.triangle_count += 2;
        }
    return out;
}

/* Preprocesses lines, and points beside them (NULL: none), into a file. */
static inline stp_status line_set_run(const stp_line_set *lines, prep_cloud *points,
                                      const char *path, unsigned threads,
                                      const stp_prep_params *params, stp_prep_stats *stats,
                                      stp_error *err)
{
    return prep_shapes_run(points, lines, NULL, path, threads, params, stats, err);
}

/* A strip patch in the world. */
typedef struct line_patch {
    stp_patch patch;
    stp_sample samples[STP_LEVEL_COUNT][STP_PATCH_SAMPLES];
    stp_dvec3 origin;
} line_patch;

typedef struct line_patches {
    line_patch *list;
    size_t count;
} line_patches;

/* All strips of a file. */
static inline line_patches line_patches_read(stp_chunk_file *file)
{
    line_patches out = {0};
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        out.list = realloc(out.list, (out.count + chunk->patch_count) * sizeof *out.list);
        assert_non_null(out.list);
        for (uint32_t p = 0; p < chunk->patch_count; p++) {
            if (!(chunk->patches[p].flags & STP_PATCH_STRIP))
                continue;
            line_patch *to = &out.list[out.count++];
            to->patch = chunk->patches[p];
            to->origin = entry.origin;
            for (int l = 0; l < STP_LEVEL_COUNT; l++)
                memcpy(to->samples[l], chunk->samples[l] + chunk->level_begin[l][p],
                       to->patch.counts[l] * sizeof(stp_sample));
        }
        stp_chunk_destroy(&chunk);
    }
    return out;
}

static inline stp_dvec3 line_position(const line_patch *p, int level, unsigned i)
{
    return stp_dvec3_add(p->origin, stp_sample_position(&p->samples[level][i], &p->patch));
}

#endif
