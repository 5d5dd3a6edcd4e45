/* Tests sums over windows of heights, which are taken by columns, against sums sample by sample. */
#include "preprocess/grid/grid_windows.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#define SIDE (STP_SQUARE_SIDE + 2 * STP_GRID_REACH)
#define TRIES 2000u

/* A row of 8 heights, and those around: noise, some cliffs, some missing. */
static void make_heights(double z[SIDE][SIDE])
{
    for (unsigned r = 0; r < SIDE; r++)
        for (unsigned c = 0; c < SIDE; c++) {
            const int kind = rand() % 400;
            z[r][c] = kind == 0 ? NAN : kind < 4 ? 1000.0 : rand() % 64;
        }
}

static void check_lane(const double *middle, int reach, const stp_grid_windows *w, unsigned lane)
{
    double xz = 0.0, yz = 0.0, beyond = -INFINITY;
    for (int j = -reach; j <= reach; j++)
        for (int i = -reach; i <= reach; i++) {
            const double up = middle[j * (int)SIDE + i] - *middle;
            xz += i * up;
            yz += j * up;
            beyond = fmax(beyond, fabs(up) - (w->by_columns[abs(i)][lane] +
                                              w->by_rows[abs(j)][lane] + w->noise));
        }
    assert_int_equal(isnan(w->xz[lane] + w->yz[lane]), isnan(xz));
    if (isnan(xz))
        return;
    assert_true(w->xz[lane] == xz); /* whole numbers: nothing is rounded */
    assert_true(w->yz[lane] == yz);
    assert_int_equal(w->beyond[lane] > 0.0, beyond > 0.0);
}

static void sums_are_those_of_windows(void **state)
{
    (void)state;
    double z[SIDE][SIDE];
    const double sides[2] = {1.0, 2.0};
    for (unsigned n = 0; n < TRIES; n++) {
        const stp_height_grid grid = {.reach = 1 + n % STP_GRID_REACH, .noise = 1.0 + n % 8};
        const double *middle = &z[STP_GRID_REACH][STP_GRID_REACH];
        stp_grid_windows w;
        make_heights(z);
        stp_grid_windows_sum(middle, SIDE, sides, &grid, &w);
        for (unsigned k = 0; k < STP_SQUARE_SIDE; k++)
            if (!isnan(middle[k]))
                check_lane(middle + k, (int)grid.reach, &w, k);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(sums_are_those_of_windows)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
