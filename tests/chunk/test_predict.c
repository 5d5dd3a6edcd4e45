/* Tests the residuals of samples: any samples come back, and values that the format predicts well
 * cost next to nothing. */
#include "formats/chunk/codec/predict/predict.h"

#include "base/random.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define PATCH_COUNT 64u

/* Patch i has level0(i) samples. */
static stp_chunk *chunk_of(unsigned (*level0)(uint32_t patch))
{
    uint32_t totals[STP_LEVEL_COUNT] = {0};
    stp_chunk *chunk = NULL;
    for (uint32_t i = 0; i < PATCH_COUNT; i++)
        for (unsigned l = 0, n = level0(i); l < STP_LEVEL_COUNT; l++, n = stp_level_count_above(n))
            totals[l] += n;
    assert_int_equal(stp_chunk_create(&chunk, PATCH_COUNT, totals, 0, NULL), STP_OK);
    memset(chunk->patches, 0, PATCH_COUNT * sizeof *chunk->patches);
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        chunk->level_begin[l][0] = 0;
        for (uint32_t i = 0; i < PATCH_COUNT; i++) {
            stp_patch *p = &chunk->patches[i];
            p->counts[l] = (uint8_t)(l == 0 ? level0(i) : stp_level_count_above(p->counts[l - 1]));
            chunk->level_begin[l][i + 1] = chunk->level_begin[l][i] + p->counts[l];
        }
    }
    return chunk;
}

static stp_table table_of(uint32_t rows)
{
    int16_t *values = calloc((size_t)STP_SAMPLE_COLUMN_COUNT * rows + 1, sizeof *values);
    assert_non_null(values);
    return (stp_table){.values = values,
                       .stride = rows,
                       .column_count = STP_SAMPLE_COLUMN_COUNT,
                       .row_count = rows};
}

static stp_level_tables encode_level(const stp_chunk *chunk, int level)
{
    uint32_t elder, last;
    stp_predict_row_counts(chunk, level, &elder, &last);
    stp_level_tables tables = {.elder = table_of(elder), .last = table_of(last)};
    stp_predict_level_encode(chunk, level, &tables);
    return tables;
}

static void destroy_tables(stp_level_tables *tables)
{
    free(tables->elder.values);
    free(tables->last.values);
}

static unsigned any_count(uint32_t patch)
{
    return 1 + patch % 64;
}

static void fill_random(void *bytes, size_t size, uint64_t seed)
{
    for (size_t i = 0; i < size; i++)
        ((uint8_t *)bytes)[i] = (uint8_t)stp_random_u64(seed, i);
}

/* Parents unrelated to their children, with random numbers everywhere. */
static void test_any(void **state)
{
    (void)state;
    stp_chunk *chunk = chunk_of(any_count);
    for (uint64_t seed = 0; seed < 8; seed++) {
        for (uint32_t i = 0; i < PATCH_COUNT; i++) {
            stp_patch *p = &chunk->patches[i];
            fill_random(p->radius, sizeof p->radius, seed + 100 * i);
            fill_random(p->bound_centre, sizeof p->bound_centre, seed + 200 * i);
            fill_random(p->cone_axis, sizeof p->cone_axis, seed + 300 * i);
        }
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            fill_random(chunk->samples[l],
                        chunk->level_begin[l][PATCH_COUNT] * sizeof *chunk->samples[l],
                        seed + 10 * (unsigned)l);
        for (int l = STP_LEVEL_COUNT - 1; l >= 0; l--) {
            size_t bytes = chunk->level_begin[l][PATCH_COUNT] * sizeof *chunk->samples[l];
            stp_sample *before = malloc(bytes);
            assert_non_null(before);
            memcpy(before, chunk->samples[l], bytes);
            if (l == STP_LEVEL_COUNT - 1) {
                stp_table table = table_of(PATCH_COUNT);
                stp_predict_vertices_encode(chunk, &table);
                memset(chunk->samples[l], 0, bytes);
                stp_predict_vertices_decode(chunk, &table);
                free(table.values);
            } else {
                stp_level_tables tables = encode_level(chunk, l);
                memset(chunk->samples[l], 0, bytes);
                stp_predict_level_decode(chunk, l, &tables);
                destroy_tables(&tables);
            }
            assert_memory_equal(before, chunk->samples[l], bytes);
            free(before);
        }
    }
    stp_chunk_destroy(&chunk);
}

static unsigned full_count(uint32_t patch)
{
    (void)patch;
    return 64;
}

/* A unit normal up to `spread` radians off an axis that differs from patch to patch. */
static vec3s normal_near(uint32_t patch, uint64_t which, double spread)
{
    double around = 6.283185 * stp_random_unit(7, which);
    double off = spread * stp_random_unit(8, which);
    double tilt = 0.7 * stp_random_unit(9, patch); /* z stays positive: no seam of the map */
    double x = sin(off) * cos(around);
    double z = cos(off);
    return (vec3s){{(float)(x * cos(tilt) + z * sin(tilt)), (float)(sin(off) * sin(around)),
                    (float)(z * cos(tilt) - x * sin(tilt))}};
}

/* Merges level 1 as the format says: means weighted by area, normals of length 1. */
static void merge_level_1(stp_chunk *chunk)
{
    for (uint32_t j = 0; j < chunk->level_begin[1][PATCH_COUNT]; j++) {
        const stp_sample *child = chunk->samples[0] + 4 * (size_t)j;
        double position[3] = {0}, colour[3] = {0}, normal[3] = {0}, sum = 0.0;
        for (int k = 0; k < 4; k++) {
            double weight = exp2(child[k].radius / 8.0);
            vec3s n = stp_normal_decode(child[k].normal);
            sum += weight;
            for (int i = 0; i < 3; i++) {
                position[i] += weight * child[k].position[i];
                colour[i] += weight * child[k].rgb[i];
                normal[i] += weight * (double)n.raw[i];
            }
        }
        stp_sample *parent = &chunk->samples[1][j];
        double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
        for (int i = 0; i < 3; i++) {
            parent->position[i] = (uint16_t)lrint(position[i] / sum);
            parent->rgb[i] = (uint8_t)lrint(colour[i] / sum);
        }
        stp_normal_encode((vec3s){{(float)(normal[0] / length), (float)(normal[1] / length),
                                   (float)(normal[2] / length)}},
                          parent->normal);
    }
}

/* The parent and the other children predict the last child. Its residual is the parent's rounding,
 * divided by the last child's share of the weights. For a normal, the octahedral map stretches the
 * residual (by at most three between places), and the spread of directions shortens the sum. */
static void test_last(void **state)
{
    (void)state;
    static const int columns[] = {STP_COLUMN_GREEN,      STP_COLUMN_RED,
                                  STP_COLUMN_BLUE,       STP_COLUMN_POSITION_A,
                                  STP_COLUMN_POSITION_B, STP_COLUMN_POSITION_C};
    stp_chunk *chunk = chunk_of(full_count);
    for (uint32_t k = 0; k < chunk->level_begin[0][PATCH_COUNT]; k++) {
        stp_sample *s = &chunk->samples[0][k];
        uint64_t r = stp_random_u64(3, k);
        for (int i = 0; i < 3; i++) {
            s->position[i] = (uint16_t)(20000 + (r >> (12 * i) & 4095));
            s->rgb[i] = (uint8_t)(r >> (36 + 8 * i));
        }
        s->radius = (uint8_t)(100 + (r >> 62)); /* weights within a factor of 1.3 */
        stp_normal_encode(normal_near(k / 64, k, 0.8), s->normal);
    }
    merge_level_1(chunk);
    stp_level_tables tables = encode_level(chunk, 0);
    for (uint32_t row = 0; row < tables.last.row_count; row++) {
        for (size_t c = 0; c < sizeof columns / sizeof *columns; c++)
            assert_in_range(abs(stp_table_column(&tables.last, (unsigned)columns[c])[row]), 0, 3);
        assert_in_range(abs(stp_table_column(&tables.last, STP_COLUMN_NORMAL_U)[row]), 0, 6);
        assert_in_range(abs(stp_table_column(&tables.last, STP_COLUMN_NORMAL_V)[row]), 0, 6);
    }
    destroy_tables(&tables);
    stp_chunk_destroy(&chunk);
}

/* On a paraboloid normals turn evenly, so the elder children's normals are predicted within a few
 * codes. The parent's normal is up to twenty codes away. */
static void test_turning(void **state)
{
    (void)state;
    stp_chunk *chunk = chunk_of(full_count);
    int farthest = 0;
    for (uint32_t k = 0; k < chunk->level_begin[0][PATCH_COUNT]; k++) {
        stp_sample *s = &chunk->samples[0][k];
        /* an 8 x 8 grid in Morton order: the bits of x and y alternate */
        unsigned x = (k & 1) | (k >> 1 & 2) | (k >> 2 & 4);
        unsigned y = (k >> 1 & 1) | (k >> 2 & 2) | (k >> 3 & 4);
        double gx = 0.02 * ((double)x - 3.5);
        double gy = 0.02 * ((double)y - 3.5);
        double length = sqrt(1.0 + gx * gx + gy * gy);
        s->position[0] = (uint16_t)(30000 + 50 * x);
        s->position[1] = (uint16_t)(30000 + 50 * y);
        s->position[2] = 30000;
        s->radius = 100;
        stp_normal_encode(
            (vec3s){{(float)(gx / length), (float)(gy / length), (float)(1.0 / length)}},
            s->normal);
    }
    merge_level_1(chunk);
    for (uint32_t k = 0; k < chunk->level_begin[0][PATCH_COUNT]; k++) {
        const uint8_t *own = chunk->samples[0][k].normal;
        const uint8_t *parent = chunk->samples[1][k / 4].normal;
        int away = (own[0] | (own[1] & 15) << 8) - (parent[0] | (parent[1] & 15) << 8);
        farthest = abs(away) > farthest ? abs(away) : farthest;
    }
    assert_true(farthest > 15);
    chunk->patches[0].radius[0] = 100;
    stp_level_tables tables = encode_level(chunk, 0);
    for (uint32_t row = 0; row < tables.elder.row_count; row++) {
        assert_in_range(abs(stp_table_column(&tables.elder, STP_COLUMN_NORMAL_U)[row]), 0, 4);
        assert_in_range(abs(stp_table_column(&tables.elder, STP_COLUMN_NORMAL_V)[row]), 0, 4);
    }
    destroy_tables(&tables);
    stp_chunk_destroy(&chunk);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_any),
        cmocka_unit_test(test_last),
        cmocka_unit_test(test_turning),
    };
    return cmocka_run_group_tests_name("predict", tests, NULL, NULL);
}
