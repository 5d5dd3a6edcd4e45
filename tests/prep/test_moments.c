/* Tests planes of neighbourhoods against Jacobi's eigenvectors: scattered points, thin and thick
 * layers, lines, equal points; several at a time and one alone give the same bits. */
#include "base/random.h"
#include "preprocess/surface/moments.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { POINTS = 17, ROUNDS = 2000 };

static float next(void) /* -1 to 1 */
{
    static uint64_t drawn;
    return (float)(2.0 * stp_random_unit(7, drawn++) - 1.0);
}

/* Points in a box of these sides, on axes that are turned. */
static stp_moments moments_in(const float sides[3])
{
    stp_moments m = {{{0}}};
    for (int i = 0; i < POINTS; i++) {
        const float a = sides[0] * next(), b = sides[1] * next();
        const float c = sides[2] * next(), half = sqrtf(0.5f);
        stp_moments_add_point(&m,
                              stp_moments_place(half * (a - b), 0.6f * half * (a + b) - 0.8f * c,
                                                0.8f * half * (a + b) + 0.6f * c));
    }
    return m;
}

/* Jacobi's rotations: c becomes diagonal, v has its eigenvectors as columns. */
static void turn(double c[3][3], double v[3][3], int p, int q)
{
    const double angle = 0.5 * atan2(2.0 * c[p][q], c[q][q] - c[p][p]);
    const double s = sin(angle), k = cos(angle);
    for (int i = 0; i < 3; i++) {
        const double a = c[i][p], b = c[i][q], d = v[i][p], e = v[i][q];
        c[i][p] = k * a - s * b, c[i][q] = s * a + k * b;
        v[i][p] = k * d - s * e, v[i][q] = s * d + k * e;
    }
    for (int i = 0; i < 3; i++) {
        const double a = c[p][i], b = c[q][i];
        c[p][i] = k * a - s * b, c[q][i] = s * a + k * b;
    }
}

/* The variances, least first, and the direction of the least. */
static stp_dvec3 jacobi(const stp_moments *m, double variances[3])
{
    double c[3][3], v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    int order[3] = {0, 1, 2};
    const double n = (double)m->row[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            c[i][j] =
                (double)m->row[i][j] / n - (double)m->row[3][i] / n * ((double)m->row[3][j] / n);
    for (int sweep = 0; sweep < 30; sweep++)
        for (int p = 0; p < 2; p++)
            for (int q = p + 1; q < 3; q++)
                turn(c, v, p, q);
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2 - i; j++)
            if (c[order[j]][order[j]] > c[order[j + 1]][order[j + 1]]) {
                const int other = order[j];
                order[j] = order[j + 1];
                order[j + 1] = other;
            }
    for (int i = 0; i < 3; i++)
        variances[i] = c[order[i]][order[i]];
    return (stp_dvec3){v[0][order[0]], v[1][order[0]], v[2][order[0]]};
}

static void fit(const stp_moments m[STP_MOMENTS_LANES], stp_moments_plane out[STP_MOMENTS_LANES])
{
    stp_moment_columns columns;
    for (int i = 0; i < STP_MOMENTS_LANES; i++) {
        float sums[STP_MOMENT_SUMS];
        stp_moments_get(&m[i], sums);
        for (int j = 0; j < STP_MOMENT_SUMS; j++)
            columns.of[j][i] = sums[j];
    }
    stp_moments_fit(&columns, out);
}

static void check(const stp_moments *m, const stp_moments_plane *plane)
{
    double v[3];
    const stp_dvec3 axis = jacobi(m, v);
    const stp_dvec3 n = stp_dvec3_from_float(plane->normal);
    const double third = (v[0] + v[1] + v[2]) / 3.0;
    assert_true(fabs((double)plane->variance - v[0]) <= 1e-5 * third + 1e-6 * v[0]);
    assert_true(fabs((double)plane->roundness - v[0] * v[1] * v[2] / (third * third * third)) <=
                1e-5);
    assert_true(fabs(stp_dvec3_length(n) - 1.0) < 1e-6);
    /* the closer the lesser two are, the less the direction says */
    const double angle = stp_dvec3_length(stp_dvec3_cross(n, axis));
    assert_true(angle * (v[1] - v[0]) <= 1e-4 * third);
}

static void planes_are_those_of_jacobi(void **state)
{
    (void)state;
    for (int round = 0; round < ROUNDS; round++) {
        stp_moments m[STP_MOMENTS_LANES];
        stp_moments_plane out[STP_MOMENTS_LANES];
        for (int i = 0; i < STP_MOMENTS_LANES; i++) {
            const float thin = powf(10.0f, -4.0f * fabsf(next()));
            const float sides[3] = {1.0f, i % 2 ? 1.0f : 0.5f + 0.5f * thin, i < 6 ? thin : 1.0f};
            m[i] = moments_in(sides);
        }
        fit(m, out);
        for (int i = 0; i < STP_MOMENTS_LANES; i++) {
            const vec3s alone = stp_moments_normal(&m[i]);
            check(&m[i], &out[i]);
            assert_memory_equal(&alone, &out[i].normal, sizeof alone);
        }
    }
}

/* On a line, or at one place, there is no plane. */
static void no_plane(void **state)
{
    (void)state;
    const float sides[2][3] = {{0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 0.0f}};
    stp_moments m[STP_MOMENTS_LANES] = {{{{0}}}};
    stp_moments_plane out[STP_MOMENTS_LANES];
    for (int i = 0; i < 2; i++)
        m[i] = moments_in(sides[i]);
    fit(m, out);
    for (int i = 0; i < 2; i++) {
        assert_true(glms_vec3_norm2(out[i].normal) == 0.0f);
        assert_true(fabsf(out[i].variance) < 1e-6f);
        assert_true(fabsf(out[i].roundness) < 1e-6f);
    }
}

/* Points on a plane through the origin leave no variance, and their normal is exact. */
static void exact_plane(void **state)
{
    (void)state;
    stp_moments m[STP_MOMENTS_LANES] = {{{{0}}}};
    stp_moments_plane out[STP_MOMENTS_LANES];
    for (int i = 0; i < POINTS; i++)
        stp_moments_add_point(&m[0], stp_moments_place((float)(i % 4), (float)(i / 4), 0.0f));
    fit(m, out);
    assert_true(out[0].variance == 0.0f);
    assert_true(fabsf(out[0].normal.z) == 1.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(planes_are_those_of_jacobi),
        cmocka_unit_test(no_plane),
        cmocka_unit_test(exact_plane),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
