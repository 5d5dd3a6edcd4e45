/* Tests what maps are made of: parts and merged parts keep the cone; sheets above each other and
 * steps are no height field; heights of meshes do not jump. */
#include "base/random.h"
#include "preprocess/maps/map_faces.h"
#include "preprocess/maps/parts/part_cut.h"
#include "preprocess/maps/parts/part_field.h"
#include "preprocess/maps/parts/part_within.h"
#include "preprocess/prep.h"
#include "tests/fixtures/surface_fixture.h"

#define DEGREE (M_PI / 180.0)

static void test_parts_keep_the_cone(void **state)
{
    surface_cloud s = surface_scan(GEN_TORUS, 20000, 0.0, 0);
    const double cosine = cos(50.0 * DEGREE);
    uint32_t *numbers = calloc(s.cloud.count, sizeof *numbers), points = 0;
    stp_cell_parts cell = {0};
    stp_error err = {0};
    (void)state;
    surface_prepare(&s, STP_PREP_NEIGHBOURS);
    surface_orient(&s, (stp_orient_params){.mode = STP_ORIENT_PROPAGATE});
    assert_non_null(numbers);
    assert_int_equal(s.cloud.cell_count, 1);
    assert_int_equal(stp_cell_parts_cut(&cell, &s.cloud, 0, cosine, numbers, &err), STP_OK);
    const uint32_t cut = cell.part_count;
    assert_true(cut > 20);
    assert_int_equal(stp_cell_parts_merge(&cell, &s.cloud, 0, 50.0 * DEGREE, numbers, &err),
                     STP_OK);
    assert_true(cell.part_count < 0.6 * cut);
    uint32_t *found = calloc(cell.part_count, sizeof *found);
    assert_non_null(found);
    for (uint32_t i = 0; i < s.cloud.count; i++) {
        assert_true(numbers[i] < cell.part_count);
        const stp_part *part = &cell.parts[numbers[i]];
        const stp_dvec3 n = stp_dvec3_from_float(stp_cloud_normal(&s.cloud, i));
        assert_true(stp_dvec3_dot(n, part->cone.axis) >= cosine - 1e-6);
        found[numbers[i]]++;
    }
    for (uint32_t p = 0; p < cell.part_count; p++) {
        assert_int_equal(found[p], cell.parts[p].points);
        points += found[p];
    }
    assert_int_equal(points, s.cloud.count);
    for (size_t i = 0; i < cell.pair_count; i++)
        assert_true(cell.pairs[i].a < cell.pairs[i].b && cell.pairs[i].b < cell.part_count);
    free(found);
    free(numbers);
    stp_cell_parts_clear(&cell);
    surface_clear(&s);
}

/* Two sheets, the odd points 0.5 above the even ones. */
static surface_cloud two_sheets(uint32_t count)
{
    surface_cloud s = {.cloud = {.count = count, .capacity = count}};
    s.cloud.points = calloc(count, sizeof *s.cloud.points);
    assert_non_null(s.cloud.points);
    for (uint32_t i = 0; i < count; i++)
        s.cloud.points[i] = (stp_cloud_point){
            .position = {stp_random_unit(1, i), stp_random_unit(2, i), 0.5 * (i % 2)}, .source = i};
    surface_prepare(&s, STP_PREP_NEIGHBOURS);
    surface_orient(&s, (stp_orient_params){.mode = STP_ORIENT_PROPAGATE});
    return s;
}

enum { SHEET, SIDE_OF_SHEET, SIDE_OF_EACH };

static uint32_t number_of(stp_dvec3 p, int parts)
{
    const bool right = p.x > 0.5, upper = p.z > 0.25;
    if (parts == SHEET)
        return upper;
    if (parts == SIDE_OF_SHEET)
        return upper ? STP_PART_NONE : right;
    return upper == right ? right : STP_PART_NONE;
}

/* Sheets above each other, and two that meet at unequal heights, are no height field together;
 * two sides of one are. */
static void test_field(void **state)
{
    const stp_normal_cone up = {.axis = {0.0, 0.0, 1.0}, .cosine = 1.0};
    surface_cloud s = two_sheets(8000);
    const stp_rank_part all = {0, s.cloud.count};
    uint32_t *numbers = calloc(s.cloud.count, sizeof *numbers);
    (void)state;
    assert_non_null(numbers);
    for (int parts = SHEET; parts <= SIDE_OF_EACH; parts++) {
        stp_part_field field = {0};
        stp_error err = {0};
        bool fits = false;
        for (uint32_t i = 0; i < s.cloud.count; i++)
            numbers[i] = number_of(s.cloud.points[i].position, parts);
        assert_int_equal(
            stp_part_field_create(&field, &s.cloud, all, numbers, 2, NULL, 60.0 * DEGREE, &err),
            STP_OK);
        assert_int_equal(stp_part_field_fits(&field, 0, 1, &up, &fits, &err), STP_OK);
        assert_int_equal(fits, parts == SIDE_OF_SHEET);
        stp_part_field_clear(&field);
    }
    free(numbers);
    surface_clear(&s);
}

/* A place is lifted onto the triangle over it, but not where it would jump from its neighbours. */
static void test_lift(void **state)
{
    const double jumps[STP_MAP_BESIDE] = {2.0, 2.0, 2.5, 2.5};
    (void)state;
    for (int jump = 0; jump < 2; jump++) {
        const double z = jump ? 3.0 : 1.0;
        stp_map_face face = {.at = {{0.6, 0.6, z}, {1.6, 0.8, z}, {0.8, 1.6, z}}};
        const stp_map_faces faces = {&face, 1};
        float slopes[9], heights[9] = {0}, lifted[9];
        for (int i = 0; i < 9; i++)
            slopes[i] = 8.0f; /* 1.5 spacings from the surface are 4.5 upwards */
        stp_map_faces_lift(&faces, 3, 3, slopes, jumps, heights, lifted);
        for (int i = 0; i < 9; i++)
            assert_true(heights[i] == (i == 4 && !jump ? 1.0f : 0.0f));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts_keep_the_cone),
        cmocka_unit_test(test_field),
        cmocka_unit_test(test_lift),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
