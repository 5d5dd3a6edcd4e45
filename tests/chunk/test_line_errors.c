/* Tests the errors of strips against dense samples of what is drawn: the stored error is never
 * smaller than the true one, and hardly larger. */
#include "base/sort.h"
#include "tests/fixtures/line_fixture.h"

#define OUT "test_line_errors.stipple"
/* The number of points on each edge that are compared. */
#define DENSE 16u

/* A place on a polyline with its half-width. */
typedef struct ball {
    stp_dvec3 at;
    double radius;
} ball;

static ball ball_of(const line_patch *p, int level, unsigned i)
{
    return (ball){line_position(p, level, i), stp_sample_radius(&p->samples[level][i], &p->patch)};
}

static ball between(ball a, ball b, double t)
{
    return (ball){stp_dvec3_add(a.at, stp_dvec3_scale(stp_dvec3_sub(b.at, a.at), t)),
                  a.radius + t * (b.radius - a.radius)};
}

/* The least of distance + difference of half-widths, over a level's polyline. */
static double off_level(const line_patch *p, int level, ball from)
{
    double least = INFINITY;
    for (unsigned i = 1; i < p->patch.counts[level]; i++) {
        ball a = ball_of(p, level, i - 1), b = ball_of(p, level, i);
        for (unsigned k = 0; k <= 4 * DENSE; k++) {
            ball on = between(a, b, (double)k / (4.0 * DENSE));
            double d = stp_dvec3_length(stp_dvec3_sub(on.at, from.at));
            least = fmin(least, d + fabs(on.radius - from.radius));
        }
    }
    return least;
}

/* One-sided Hausdorff distance from one level's polyline to another's; both are sampled densely. */
static double one_way(const line_patch *p, int from, int to)
{
    double greatest = 0.0;
    for (unsigned i = 1; i < p->patch.counts[from]; i++)
        for (unsigned k = 0; k <= DENSE; k++)
            greatest = fmax(greatest, off_level(p, to,
                                                between(ball_of(p, from, i - 1),
                                                        ball_of(p, from, i), (double)k / DENSE)));
    return greatest;
}

/* A sampled distance exceeds the true one by at most half a step of the coarser sampling. */
static double slack_of(const line_patch *p, int level)
{
    double longest = 0.0;
    for (unsigned i = 1; i < p->patch.counts[level]; i++)
        longest = fmax(longest, stp_dvec3_length(stp_dvec3_sub(line_position(p, level, i),
                                                               line_position(p, level, i - 1))));
    return longest / (8.0 * DENSE);
}

static void check_kind(stp_line_kind kind)
{
    stp_line_set set = line_set_helices(6, 700, (stp_dvec3){10.0, 20.0, 0.0}, 3.0, 0.05, kind);
    stp_prep_stats stats;
    stp_error err = {0};
    if (line_set_run(&set, NULL, OUT, 2, NULL, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    stp_chunk_file *file = prep_open_verified(OUT);
    line_patches all = line_patches_read(file);
    double *ratios = calloc(2 * all.count, sizeof *ratios);
    size_t count = 0;
    assert_non_null(ratios);
    for (size_t i = 0; i < all.count; i++) {
        const line_patch *p = &all.list[i];
        for (int level = 1; level <= 2; level++) {
            if (p->patch.counts[level] < 2)
                continue;
            double stored = stp_error_decode(p->patch.error[level], p->patch.exponent);
            double there = fmax(0.0, one_way(p, 0, level) - slack_of(p, level));
            double back = fmax(0.0, one_way(p, level, 0) - slack_of(p, 0));
            double found = fmax(there, back);
            assert_true(stored >= found);
            assert_true(found > 0.0);
            ratios[count++] = stored / found;
        }
    }
    assert_true(count > 100);
    stp_sort_doubles(ratios, count);
    print_message("%zu levels: stored over found %.3f median, %.3f at most\n", count,
                  ratios[count / 2], ratios[count - 1]);
    if (kind == STP_LINE_TUBE) /* a ribbon's error also covers its twist */
        assert_true(ratios[count / 2] <= 1.5);
    free(ratios);
    free(all.list);
    stp_chunk_file_close(&file);
    stp_line_set_clear(&set);
}

static void tubes_hold_their_errors(void **state)
{
    (void)state;
    check_kind(STP_LINE_TUBE);
}

static void ribbons_hold_their_errors(void **state)
{
    (void)state;
    check_kind(STP_LINE_RIBBON);
}

/* Each level is a part of the next finer one, keeps the ends and shrinks nothing. A disc covers the
 * whole patch. All quarters have equal errors. */
static void levels_are_nested(void **state)
{
    (void)state;
    stp_line_set set =
        line_set_helices(50, 97, (stp_dvec3){0.0, 0.0, 0.0}, 3.0, 0.05, STP_LINE_RIBBON);
    stp_prep_stats stats;
    assert_int_equal(line_set_run(&set, NULL, OUT, 2, NULL, &stats, NULL), STP_OK);
    stp_chunk_file *file = prep_open_verified(OUT);
    line_patches all = line_patches_read(file);
    for (size_t i = 0; i < all.count; i++) {
        const line_patch *p = &all.list[i];
        const uint8_t *counts = p->patch.counts;
        assert_int_equal(p->patch.cone_angle, 255);
        assert_true(p->patch.flags & STP_PATCH_TWO_SIDED);
        for (int l = 1; l < STP_LEVEL_COUNT; l++) {
            const stp_sample *finer = p->samples[l - 1];
            assert_true(p->patch.error[l] >= p->patch.error[l - 1]);
            assert_true(p->patch.colour_error[l] >= p->patch.colour_error[l - 1]);
            for (unsigned q = 0; q < counts[2]; q++)
                assert_int_equal(stp_quarter_error(&p->patch, l, q), p->patch.error[l]);
            for (unsigned j = 0; counts[l] > 1 && j < counts[l]; j++) {
                unsigned k = stp_level_children_begin(j, counts[l], counts[l - 1]);
                unsigned end = stp_level_children_begin(j + 1, counts[l], counts[l - 1]);
                while (k < end && memcmp(&p->samples[l][j], &finer[k], sizeof *finer) != 0)
                    k++;
                assert_true(k < end);
                assert_true(j > 0 || k == 0);
                assert_true(j + 1u < counts[l] || k + 1u == counts[l - 1]);
            }
            for (unsigned k = 0; counts[l] == 1 && k < counts[0]; k++) {
                ball disc = ball_of(p, l, 0), v = ball_of(p, 0, k);
                double d = stp_dvec3_length(stp_dvec3_sub(disc.at, v.at));
                assert_true(d + v.radius <= disc.radius * (1.0 + 1e-6));
                assert_true(stp_error_decode(p->patch.error[l], p->patch.exponent) >=
                            2.0 * disc.radius * (1.0 - 1e-6));
            }
        }
    }
    free(all.list);
    stp_chunk_file_close(&file);
    stp_line_set_clear(&set);
}

/* In inner chunks, the error of a merged line covers the ball around everything that it stands
 * for. */
static void trees_hold_their_errors(void **state)
{
    (void)state;
    stp_line_set set =
        line_set_helices(300, 800, (stp_dvec3){0.0, 0.0, 0.0}, 1.0, 0.01, STP_LINE_TUBE);
    stp_prep_stats stats;
    stp_chunk_entry entry;
    assert_int_equal(line_set_run(&set, NULL, OUT, 2, NULL, &stats, NULL), STP_OK);
    stp_chunk_file *file = prep_open_verified(OUT);
    stp_chunk *root = prep_chunk(file, 0, &entry);
    assert_true(entry.child_count > 1);
    for (uint32_t p = 0; p < root->patch_count; p++) {
        const stp_patch *patch = &root->patches[p];
        assert_false(patch->flags & STP_PATCH_SHAPES);
        assert_true(patch->flags & STP_PATCH_TWO_SIDED);
        for (uint32_t i = root->level_begin[0][p]; i < root->level_begin[0][p + 1]; i++) {
            const stp_sample *s = &root->samples[0][i];
            assert_int_equal(stp_sample_kind_of(s), STP_KIND_TUBE);
            assert_true(stp_error_decode(patch->error[0], patch->exponent) >=
                        2.0 * stp_sample_radius(s, patch) * (1.0 - 1e-6));
        }
        const stp_sample *top = &root->samples[3][root->level_begin[3][p]];
        if (patch->counts[0] > 1)
            assert_int_equal(stp_sample_kind_of(top), STP_KIND_SURFACE);
    }
    stp_chunk_destroy(&root);
    stp_chunk_file_close(&file);
    stp_line_set_clear(&set);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tubes_hold_their_errors),
        cmocka_unit_test(ribbons_hold_their_errors),
        cmocka_unit_test(levels_are_nested),
        cmocka_unit_test(trees_hold_their_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
