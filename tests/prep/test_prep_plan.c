/* Tests what a rank plans for: its own share of the points, what it reads, and little of all. */
#include "preprocess/cloud/scan_lines.h"
#include "preprocess/prep.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#define POINTS UINT64_C(40000000)
#define MEMORY (UINT64_C(1) << 28)

/* Temporary files of rank `self` of `count` with a little memory. */
static uint64_t temporary(unsigned self, unsigned count, stp_prep_size size)
{
    stp_ranks ranks = {.self = self, .count = count};
    const stp_prep_params params = {.memory_bytes = MEMORY, .ranks = count > 1 ? &ranks : NULL};
    stp_prep_plan plan = {0};
    stp_error err = {0};
    size.points = POINTS;
    assert_int_equal(stp_prep_plan_make(&plan, "m.stipple", &size, &params, 1, &err), STP_OK);
    assert_true(plan.most_temporary_bytes >= plan.temporary_bytes || plan.temporary_bytes == 0);
    const uint64_t bytes = plan.temporary_bytes;
    stp_prep_plan_clear(&plan);
    return bytes;
}

static void test_share(void **state)
{
    (void)state;
    const uint64_t alone = temporary(0, 1, (stp_prep_size){0});
    assert_true(alone > 60 * POINTS);
    assert_int_equal(temporary(1, 4, (stp_prep_size){.read = POINTS / 4}), alone); /* all points */
    for (unsigned count = 4; count <= 64; count *= 4) {
        const stp_prep_size even = {.shared = true, .read = POINTS / count};
        const stp_prep_size file = {.shared = true, .read = POINTS}; /* that one rank reads */
        const uint64_t share = temporary(1, count, even);
        assert_true(share < 2 * alone / count + 10 * POINTS);
        assert_true(share > alone / count);
        assert_int_equal(temporary(0, count, even), share);
        assert_true(temporary(1, count, file) > share + 30 * POINTS);
    }
}

/* Rank 0 writes the attributes of all. */
static void test_attributes(void **state)
{
    (void)state;
    stp_prep_size size = {.shared = true, .read = POINTS / 8};
    const uint64_t without = temporary(1, 8, size);
    size.number_bytes = 40;
    assert_int_equal(temporary(1, 8, size), without + 2 * 40 * POINTS / 8);
    assert_int_equal(temporary(0, 8, size), without + 40 * POINTS / 8 + 40 * POINTS);
}

/* Ranks share a grid of heights: each has its tiles, and while it reads, a part of the rows. */
static void test_grid(void **state)
{
    (void)state;
    const uint64_t alone = temporary(0, 1, (stp_prep_size){.grid = true});
    const stp_prep_size whole = {.grid = true, .read = POINTS};
    stp_prep_size part = {.grid = true, .shared = true, .read = POINTS / 4};
    assert_int_equal(temporary(1, 4, whole), alone); /* each reads everything */
    const uint64_t share = temporary(1, 4, part);
    assert_true(share > alone / 4);
    assert_true(share < alone / 4 + 12 * POINTS);
    part.bent = true;
    assert_int_equal(temporary(1, 4, part), share + 2 * 16 * POINTS / 4);
}

/* The most that a run over POINTS needs with so many neighbours. */
static uint64_t most(unsigned neighbours)
{
    const stp_prep_params params = {.memory_bytes = MEMORY, .neighbour_count = neighbours};
    const stp_prep_size size = {.points = POINTS};
    stp_prep_plan plan = {0};
    stp_error err = {0};
    assert_int_equal(stp_prep_plan_make(&plan, "m.stipple", &size, &params, 1, &err), STP_OK);
    const uint64_t bytes = plan.most_temporary_bytes;
    stp_prep_plan_clear(&plan);
    return bytes;
}

/* Points may lie in scan lines, which nobody knows before they are read. */
static void test_lines(void **state)
{
    (void)state;
    assert_int_equal(most(0), most(STP_SCAN_LINE_NEIGHBOURS));
    assert_true(most(0) > most(STP_PREP_NEIGHBOURS) + 100 * POINTS);
}

/* Whether a run takes so many points. */
static bool takes(uint64_t points, const stp_maps_params *maps)
{
    const stp_prep_file file = {.name = "points"};
    const stp_prep_source source = {.point_count = points, .files = &file, .file_count = 1};
    const stp_prep_params params = {.maps = maps};
    stp_error err = {0};
    const stp_status status = stp_prep_check_count(&source, &params, &err);
    assert_true(status == STP_OK || status == STP_LIMIT);
    return status == STP_OK;
}

/* Points are numbered with 38 bits, but with 32 where maps are made of them. */
static void test_limits(void **state)
{
    (void)state;
    const stp_maps_params maps = {0};
    const uint64_t narrow = UINT32_MAX - 2, wide = (UINT64_C(1) << 38) - 1;
    assert_true(takes(wide, NULL) && takes(narrow, &maps));
    assert_false(takes(wide + 1, NULL) || takes(narrow + 1, &maps));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_share), cmocka_unit_test(test_attributes),
        cmocka_unit_test(test_grid), cmocka_unit_test(test_lines), cmocka_unit_test(test_limits)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
