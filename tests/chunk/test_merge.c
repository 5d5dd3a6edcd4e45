/* Tests the errors of merged discs, which are measured several at a time, against the formulas of
 * patch_bounds.h, disc by disc and point by point. */
#include "base/random.h"
#include "formats/chunk/measure/patch_bounds.h"
#include "preprocess/patch/level_error.h"
#include "tests/support/check.h"

enum { CASES = 4000, MOST = 64 };

static double between(uint64_t *next, double low, double high)
{
    return low + (high - low) * stp_random_unit(5, (*next)++);
}

static stp_dvec3 direction(uint64_t *next, double spread)
{
    const double x = between(next, -spread, spread), y = between(next, -spread, spread);
    return stp_dvec3_normalize((stp_dvec3){x, y, 1.0});
}

/* kind: bits 0 some discs stand for others, 1 some have no normal, 2 the merged one has none,
 * 3 it has no radius. */
static void make(uint64_t *next, unsigned kind, unsigned count, stp_disc *merged, stp_disc *discs)
{
    *merged = (stp_disc){.centre = {100.0, -50.0, 7.0},
                         .normal = direction(next, 0.2),
                         .radius = between(next, 1.0, 8.0)};
    if (kind & 4)
        merged->normal = (stp_dvec3){0.0, 0.0, 0.0};
    if (kind & 8)
        merged->radius = 0.0;
    for (unsigned i = 0; i < count; i++) {
        const double radius = between(next, 0.1, 2.0);
        stp_disc *d = &discs[i];
        *d = (stp_disc){.normal = direction(next, 0.5), .radius = radius};
        const stp_dvec3 off = {between(next, -4.0, 4.0), between(next, -4.0, 4.0),
                               between(next, -0.5, 0.5)};
        d->centre = stp_dvec3_add(merged->centre, off);
        d->reach = d->bound = radius;
        if (kind & 2 && between(next, 0.0, 1.0) < 0.3)
            d->normal = (stp_dvec3){0.0, 0.0, 0.0};
        if (!(kind & 1) || between(next, 0.0, 1.0) < 0.3)
            continue;
        d->low = between(next, -0.3, 0.0);
        d->high = between(next, 0.0, 0.3);
        d->reach += between(next, 0.0, 1.0);
        d->bound += between(next, 0.0, 1.0);
        d->cone = between(next, 0.01, 0.5);
        d->error = between(next, 0.0, 0.4);
    }
}

static bool has_normal(const stp_disc *d)
{
    return stp_dvec3_length(d->normal) > 0.5;
}

static void add_disc(const stp_disc *merged, const stp_disc *d, stp_merge_error *out)
{
    const bool known = has_normal(merged) && has_normal(d);
    const stp_dvec3 off = stp_dvec3_sub(d->centre, merged->centre);
    const double cosine = stp_dvec3_dot(d->normal, merged->normal);
    const double sine = sqrt(fmax(0.0, 1.0 - cosine * cosine));
    const double height = stp_dvec3_dot(off, merged->normal), far = stp_dvec3_length(off);
    const double across = sqrt(fmax(0.0, far * far - height * height));
    const double a = d->low * cosine, b = d->high * cosine, tilt = d->reach * sine;
    out->high = fmax(out->high, height + fmax(a, b) + tilt);
    out->low = fmin(out->low, height + fmin(a, b) - tilt);
    out->reach = fmax(out->reach, across + d->reach + fmax(-d->low, d->high) * sine);
    out->bound = fmax(out->bound, far + d->bound);
    out->cone = fmax(out->cone, (known ? acos(fmin(1.0, cosine)) : 0.0) + d->cone);
    out->error = fmax(out->error, d->error);
}

/* The height of a point over the disc that is nearest to it, with that disc's error. */
static double height_over_nearest(stp_dvec3 p, const stp_disc *discs, unsigned count)
{
    double least = INFINITY, found = 0.0;
    for (unsigned i = 0; i < count; i++) {
        const stp_dvec3 off = stp_dvec3_sub(p, discs[i].centre);
        const double h = stp_dvec3_dot(off, discs[i].normal);
        const double across = sqrt(fmax(0.0, stp_dvec3_dot(off, off) - h * h));
        const double o = fmax(0.0, across - discs[i].radius), squared = h * h + o * o;
        if (squared < least) {
            least = squared;
            found = fabs(h) + discs[i].error;
        }
    }
    return found;
}

static stp_merge_error expected(const stp_disc *merged, const stp_disc *discs, unsigned count)
{
    stp_merge_error out = {.low = INFINITY, .high = -INFINITY};
    stp_dvec3 points[STP_DISC_POINTS];
    const unsigned point_count = stp_disc_points(merged, points);
    for (unsigned i = 0; i < count; i++)
        add_disc(merged, &discs[i], &out);
    for (unsigned i = 0; i < point_count; i++)
        out.error = fmax(out.error, height_over_nearest(points[i], discs, count));
    const double side = fmax(out.high, -out.low);
    out.least_error = fmax(out.error, fmin(side, out.high - out.low));
    out.error = fmax(out.error, side);
    return out;
}

static void merged_discs(void **state)
{
    (void)state;
    uint64_t next = 0;
    for (unsigned i = 0; i < CASES; i++) {
        stp_disc merged, discs[MOST];
        const unsigned count = 1 + i % MOST;
        make(&next, i / MOST % 16, count, &merged, discs);
        const stp_merge_error is = stp_merge_measure(&merged, discs, count);
        const stp_merge_error should = expected(&merged, discs, count);
        const stp_error_bounds bounds = stp_merge_bound_error(&merged, discs, count);
        check_near(is.error, should.error, 1e-9);
        check_near(stp_merge_measure_rim(&merged, discs, count, bounds.low), should.error, 1e-9);
        assert_true(bounds.low <= should.error + 1e-9 && should.error <= bounds.high + 1e-9);
        check_near(is.least_error, should.least_error, 1e-9);
        check_near(is.low, should.low, 1e-9);
        check_near(is.high, should.high, 1e-9);
        check_near(is.reach, should.reach, 1e-9);
        check_near(is.bound, should.bound, 1e-9);
        assert_true(fabs(is.cone - should.cone) <= 1e-6);
    }
}

/* Errors of levels have the codes that they would have if all discs were measured. */
static void levels_round_to_the_same_code(void **state)
{
    static const uint8_t counts[STP_LEVEL_COUNT] = {64, 16, 4, 1};
    (void)state;
    uint64_t next = 0;
    int within = 0; /* cases in which no disc need be measured */
    for (unsigned i = 0; i < CASES; i++) {
        const int level = 1 + (int)(i % 2), exponent = -10;
        const unsigned share = 64u / counts[level];
        stp_disc merged[16], finest[64];
        for (unsigned j = 0; j < 64 / share; j++) {
            make(&next, i % 2, share, &merged[j], &finest[share * j]);
            if (i % 3 == 0) /* level ground: rims lie on the discs' planes */
                for (unsigned k = 0; k < share; k++)
                    finest[share * j + k].normal = merged[j].normal;
        }
        const stp_level_discs discs = {finest, merged, counts, level};
        const double least = between(&next, 0.0, 1.0);
        double error = least, low = least, high = 0.0;
        for (unsigned j = 0; j < 64 / share; j++) {
            error = fmax(error, expected(&merged[j], &finest[share * j], share).error);
            const stp_error_bounds b = stp_merge_bound_error(&merged[j], &finest[share * j], share);
            low = fmax(low, b.low);
            high = fmax(high, b.high);
        }
        const double found = stp_level_error(&discs, 0, counts[level], exponent, least);
        assert_int_equal(stp_error_encode(found, exponent), stp_error_encode(error, exponent));
        within += stp_error_encode(low, exponent) == stp_error_encode(high, exponent);
    }
    print_message("%d of %d by bounds alone\n", within, CASES);
    assert_true(within > CASES / 100 && within < CASES / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(merged_discs),
                                       cmocka_unit_test(levels_round_to_the_same_code)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
