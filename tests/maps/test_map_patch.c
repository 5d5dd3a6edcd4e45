/* Tests how samples of elevation maps and depth images are merged: they lie where the codec expects
 * them, and discs of full cells of a map have the radius of their steepness. */
#include "base/random.h"
#include "formats/chunk/codec/square/square.h"
#include "formats/chunk/sample/normal_grid.h"
#include "preprocess/patch/merged_radius.h"
#include "preprocess/patch/patch_build.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define EXPONENT (-6)
#define BITS 8u

/* A map over a tilted plane: its columns and rows, and its axis. */
static const stp_dvec3 by_column = {1.0, 0.0, -0.3}, by_row = {0.2, 1.1, -0.25};
static const stp_patch_grid grid = {
    .along = {0.37, 0.61, 1.0}, .spacing = 1.2, .merged_bits = BITS};

static stp_dvec3 place_of(double column, double row, double height)
{
    stp_dvec3 p = stp_dvec3_scale(by_column, column);
    p = stp_dvec3_add(p, stp_dvec3_scale(by_row, row));
    return stp_dvec3_add(p, stp_dvec3_scale(grid.along, height - p.z));
}

/* Rays of a camera, along x. */
static const stp_patch_grid rays = {.along = {1.0, 0.0, 0.0},
                                    .merged_bits = BITS,
                                    .noise = 0.6,
                                    .spreads = true,
                                    .station = {-30.0, 5.0, 2.0}};

static stp_dvec3 place_on_ray(double column, double row, double depth)
{
    const stp_dvec3 way = {1.0, 0.02 * column - 0.1, 0.03 * row + 0.05};
    return stp_dvec3_add(rays.station, stp_dvec3_scale(way, depth));
}

/* A full square with rough depths, some of them beyond a cliff. */
static void build_image(const stp_patch_grid *on, stp_patch *patch, stp_patch_samples *samples)
{
    stp_item items[STP_PATCH_SAMPLES] = {0}, vertex;
    uint32_t order[STP_PATCH_SAMPLES];
    const stp_patch_ground ground = {
        .vertex_least = EXPONENT - 8, .normal_bits = STP_NORMAL_BITS, .even = true, .grid = on};
    for (uint32_t k = 0; k < STP_PATCH_SAMPLES; k++) {
        const double depth = 30.0 + 2.0 * stp_random_unit(3, k) + (k > 37 ? 9.0 : 0.0);
        stp_item *item = &items[k];
        order[k] = k;
        item->exponent = EXPONENT;
        item->disc.centre = place_on_ray(stp_square_column(k), stp_square_row(k), depth);
        item->area = 1.0;
        item->disc.radius = item->disc.reach = item->disc.bound = 1.7;
    }
    assert_true(stp_patch_build(items, order, STP_PATCH_SAMPLES, &ground, patch, samples, &vertex));
}

/* Merged samples of an image lie on the ray of their mean column and row, at the mean depth of
 * what they are merged from, and depths are multiples of a step that is between half of and the
 * whole of their noise. */
static void test_rays(void **state)
{
    (void)state;
    for (int noisy = 0; noisy < 2; noisy++) {
        stp_patch patch;
        stp_patch_samples samples;
        stp_patch_grid on = rays;
        on.noise = noisy ? rays.noise : 0.0;
        build_image(&on, &patch, &samples);
        for (int level = 1; level <= 2; level++)
            for (uint32_t i = 0; i < patch.counts[level]; i++) {
                const double step = noisy ? ldexp(1.0, -1 - level) : ldexp(1.0, EXPONENT);
                const uint32_t first = i << 2 * level;
                const double middle = 0.5 * ((1 << level) - 1);
                const stp_dvec3 p = stp_sample_position(&samples.level[level][i], &patch);
                const stp_dvec3 expected =
                    place_on_ray(stp_square_column(first) + middle, stp_square_row(first) + middle,
                                 p.x - rays.station.x);
                double mean = 0.0;
                for (uint32_t k = 0; k < 4; k++)
                    mean +=
                        0.25 * stp_sample_position(&samples.level[level - 1][4 * i + k], &patch).x;
                assert_true(fmod(p.x, step) == 0.0);
                assert_true(fabs(p.x - mean) <= 0.75 * step + ldexp(1.0, EXPONENT));
                assert_true(fabs(p.y - expected.y) <= ldexp(1.0, EXPONENT - 1) + 1e-9);
                assert_true(fabs(p.z - expected.z) <= ldexp(1.0, EXPONENT - 1) + 1e-9);
            }
    }
}

/* The first samples of a square, with rough heights that are multiples of the step, and rough
 * normals. */
static void build(double steepness, uint32_t count, stp_patch *patch, stp_patch_samples *samples)
{
    stp_item items[STP_PATCH_SAMPLES] = {0}, vertex;
    uint32_t order[STP_PATCH_SAMPLES];
    const double step = ldexp(1.0, EXPONENT);
    const stp_patch_ground ground = {
        .vertex_least = EXPONENT - 8, .normal_bits = STP_NORMAL_BITS, .even = true, .grid = &grid};
    for (uint32_t k = 0; k < count; k++) {
        const double height = step * floor(40.0 * stp_random_unit(1, k));
        stp_item *item = &items[k];
        order[k] = k;
        item->exponent = EXPONENT;
        item->flags = STP_SAMPLE_HAS_NORMAL | STP_SAMPLE_ORIENTED;
        item->disc.centre = place_of(stp_square_column(k), stp_square_row(k), height);
        item->disc.normal = stp_dvec3_normalize((stp_dvec3){
            grid.along.x + steepness + 0.4 * stp_random_unit(2, k), grid.along.y, grid.along.z});
        stp_normal_encode_on(stp_dvec3_to_float(item->disc.normal), STP_NORMAL_BITS, item->normal);
        item->area = grid.spacing * grid.spacing *
                     stp_stretch(stp_dvec3_dot(item->disc.normal, stp_dvec3_normalize(grid.along)));
        item->disc.radius = item->disc.reach = item->disc.bound = 1.7 * sqrt(item->area);
    }
    assert_true(stp_patch_build(items, order, count, &ground, patch, samples, &vertex));
    assert_int_equal(patch->exponent, EXPONENT);
}

/* Across the height a merged sample is off its place, the mean of its children's columns and rows
 * at its own height, by half a step at most: by its rounding alone. */
static void test_places(void **state)
{
    stp_patch patch;
    stp_patch_samples samples;
    const double half = ldexp(1.0, EXPONENT - 1) + 1e-9;
    (void)state;
    build(0.0, STP_PATCH_SAMPLES, &patch, &samples);
    for (int level = 1; level <= 2; level++)
        for (uint32_t i = 0; i < patch.counts[level]; i++) {
            const uint32_t first = i << 2 * level;
            const double middle = 0.5 * ((1 << level) - 1);
            const stp_dvec3 p = stp_sample_position(&samples.level[level][i], &patch);
            const stp_dvec3 expected =
                place_of(stp_square_column(first) + middle, stp_square_row(first) + middle, p.z);
            assert_true(fabs(p.x - expected.x) <= half);
            assert_true(fabs(p.y - expected.y) <= half);
        }
}

/* Discs of a level are as large as their steepness says, and their normals on the map's grid. */
static void test_radii_and_normals(void **state)
{
    static const double steepness[] = {0.0, 0.9, 2.5};
    (void)state;
    for (size_t s = 0; s < 3; s++) {
        stp_patch patch;
        stp_patch_samples samples;
        build(steepness[s], STP_PATCH_SAMPLES, &patch, &samples);
        for (int level = 1; level <= 2; level++) {
            const stp_sample *of = samples.level[level];
            assert_int_equal(stp_normal_grid_shift(of, patch.counts[level]),
                             STP_NORMAL_BITS - BITS);
            for (uint32_t i = 0; i < patch.counts[level]; i++) {
                const stp_dvec3 n = stp_dvec3_from_float(stp_normal_decode(of[i].normal));
                const double stretch =
                    stp_stretch(stp_dvec3_dot(n, stp_dvec3_normalize(grid.along)));
                const double radius =
                    STP_MERGED_LAMBDA * ldexp(grid.spacing, level) * sqrt(stretch);
                assert_int_equal(of[i].radius, stp_radius_encode(radius, EXPONENT));
            }
        }
    }
}

/* Discs of cells that are not full are a half of an octave, or more of them, from that. */
static void test_radii_of_parts(void **state)
{
    unsigned others = 0;
    (void)state;
    for (uint32_t count = 2; count < STP_PATCH_SAMPLES; count += 3) {
        stp_patch patch;
        stp_patch_samples samples;
        build(0.5, count, &patch, &samples);
        for (int level = 1; level <= 2; level++)
            for (uint32_t i = 0; i < patch.counts[level]; i++) {
                const stp_sample *s = &samples.level[level][i];
                const unsigned children =
                    stp_level_children_begin(i + 1, patch.counts[level], patch.counts[level - 1]) -
                    stp_level_children_begin(i, patch.counts[level], patch.counts[level - 1]);
                const stp_dvec3 n = stp_dvec3_from_float(stp_normal_decode(s->normal));
                const double stretch =
                    stp_stretch(stp_dvec3_dot(n, stp_dvec3_normalize(grid.along)));
                const double full = STP_MERGED_LAMBDA * ldexp(grid.spacing, level) * sqrt(stretch);
                bool found = children == 1;
                for (int half = -8; half <= 8 && !found; half++)
                    found = s->radius == stp_radius_encode(full * exp2(0.5 * half), EXPONENT);
                assert_true(found);
                others += children > 1 && s->radius != stp_radius_encode(full, EXPONENT);
            }
    }
    assert_true(others > 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_places),
        cmocka_unit_test(test_radii_and_normals),
        cmocka_unit_test(test_radii_of_parts),
        cmocka_unit_test(test_rays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
