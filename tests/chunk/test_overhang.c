/* Tests tangential errors against a plain search of all discs, and on a flat sheet with a
 * border. */
#include "formats/chunk/measure/overhang.h"
#include "formats/chunk/measure/patch_bounds.h"
#include "runtime/cut/level_rule.h"
#include "tests/fixtures/prep_fixture.h"

#define OUT "test_overhang.stipple"

/* The only chunk of a model of this cloud. */
static stp_chunk *build_chunk(prep_cloud *cloud)
{
    stp_prep_stats stats;
    stp_chunk_entry entry;
    assert_int_equal(prep_cloud_run(cloud, OUT, 2, NULL, &stats, NULL), STP_OK);
    stp_chunk_file *file = prep_open_verified(OUT);
    assert_int_equal(stp_chunk_file_get_info(file)->chunk_count, 1);
    stp_chunk *chunk = prep_chunk(file, 0, &entry);
    stp_chunk_file_close(&file);
    free(cloud->points);
    return chunk;
}

static stp_disc disc_at(const stp_chunk *chunk, uint32_t patch, int level, uint32_t index)
{
    return stp_disc_from_sample(&chunk->samples[level][chunk->level_begin[level][patch] + index],
                                &chunk->patches[patch]);
}

/* Returns the distance of x from a disc; also its height over the plane and its overhang beyond the
 * rim. */
static double away(stp_dvec3 x, const stp_disc *disc, double *height, double *overhang)
{
    stp_dvec3 v = stp_dvec3_sub(x, disc->centre);
    *height = fabs(stp_dvec3_dot(v, disc->normal));
    double across = sqrt(fmax(0.0, stp_dvec3_dot(v, v) - *height * *height));
    *overhang = fmax(0.0, across - disc->radius);
    return hypot(*height, *overhang);
}

static double sine_of_cone(const stp_patch *patch)
{
    return sin(fmin(M_PI_2, stp_cone_angle_decode(patch->cone_angle)));
}

/* The overhang of a point as a search of all discs finds it. most: by the nearest disc or by the
 * nearest own disc, whichever is less. least: the least over any disc. */
typedef struct plain {
    double most, least;
} plain;

static plain plain_max(plain a, plain b)
{
    return (plain){fmax(a.most, b.most), fmax(a.least, b.least)};
}

/* For one point. A merged disc's own discs are [first, last) of `patch`. The rule forgives that an
 * own disc other than the nearest may be farther by `forgiven`. */
static plain plain_point(const stp_chunk *chunk, uint32_t patch, uint32_t first, uint32_t last,
                         const stp_disc *merged, double error, stp_dvec3 x)
{
    double nearest = INFINITY, nearest_own = INFINITY, own = 0.0, all = 0.0, least = INFINITY;
    double forgiven = error * sine_of_cone(&chunk->patches[patch]);
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = 0; i < chunk->patches[p].counts[0]; i++) {
            stp_disc disc = disc_at(chunk, p, 0, i);
            double height, overhang, distance = away(x, &disc, &height, &overhang);
            if (p == patch && i >= first && i < last && distance < nearest_own) {
                nearest_own = distance;
                own = fmax(overhang, distance - forgiven);
            }
            bool is_own = p == patch && i >= first && i < last;
            double cosine = stp_dvec3_dot(disc.normal, merged->normal);
            double aside = is_own ? 0.0 : height * sqrt(fmax(0.0, 1.0 - cosine * cosine));
            double leg = sqrt(fmax(0.0, height * height - error * error * 1.000002));
            double counted = overhang + fmin(height, aside + leg);
            if (distance < nearest) {
                nearest = distance;
                all = counted;
            }
            least = fmin(least, counted);
        }
    return (plain){fmin(own, all), least};
}

/* The greatest overhang in quarter q; at level 3, in the whole patch. */
static plain plain_level(const stp_chunk *chunk, uint32_t p, int level, unsigned q)
{
    const stp_patch *patch = &chunk->patches[p];
    double error = stp_error_decode(stp_quarter_error(patch, level, q), patch->exponent);
    plain greatest = {0.0, 0.0};
    uint32_t begin = stp_quarter_begin(patch->counts, level, q);
    uint32_t end = stp_quarter_begin(patch->counts, level, q + 1);
    for (uint32_t j = begin; j < end; j++) {
        stp_disc merged = disc_at(chunk, p, level, j);
        stp_dvec3 points[STP_DISC_POINTS];
        unsigned count = stp_disc_points(&merged, points);
        uint32_t first = j, last = j + 1;
        for (int l = level; l > 0; l--) {
            first = stp_level_children_begin(first, patch->counts[l], patch->counts[l - 1]);
            last = stp_level_children_begin(last, patch->counts[l], patch->counts[l - 1]);
        }
        for (unsigned i = 0; i < count; i++)
            greatest =
                plain_max(greatest, plain_point(chunk, p, first, last, &merged, error, points[i]));
    }
    return greatest;
}

/* Asserts that `measured` is at least `least`; returns whether it is at most `most`, as a file
 * stores it. */
static bool is_about(double measured, plain told, const stp_patch *patch)
{
    uint8_t code = stp_error_encode(told.most, patch->exponent);
    assert_true(measured >= told.least * (1.0 - 1e-5) - 1e-12);
    return measured <= stp_error_decode(code, patch->exponent) * (1.0 + 1e-5);
}

static void agrees_with_a_plain_search(void **state)
{
    (void)state;
    prep_cloud cloud = prep_cloud_wavy(4000, (stp_dvec3){3.0, -2.0, 1.0}, 1.0);
    stp_chunk *chunk = build_chunk(&cloud);
    stp_overhang *measured = calloc(chunk->patch_count, sizeof *measured);
    stp_error err;
    assert_int_equal(stp_overhang_measure(measured, chunk, NULL, NULL, NULL, &err), STP_OK);
    size_t compared = 0, equal = 0;
    for (uint32_t p = 0; p < chunk->patch_count; p += 3) {
        const stp_patch *patch = &chunk->patches[p];
        double fine = stp_radius_decode(patch->radius[0], patch->exponent) / STP_OVERHANG_PARTS;
        plain whole = {0.0, 0.0};
        if (patch->counts[0] == 1) /* nothing is merged */
            fine = 0.0;
        for (unsigned q = 0; q < patch->counts[2]; q++) {
            plain told = {fine, fine};
            for (int level = 1; level <= 2; level++) {
                told = plain_max(told, plain_level(chunk, p, level, q));
                equal += is_about(measured[p].quarter[level - 1][q], told, patch);
                assert_true(measured[p].quarter[level - 1][q] <= measured[p].level[level]);
                compared++;
            }
            whole = plain_max(whole, told);
        }
        equal +=
            is_about(measured[p].level[3], plain_max(whole, plain_level(chunk, p, 3, 0)), patch);
        compared++;
        assert_true(measured[p].level[0] == 0.0);
    }
    print_message("%zu of %zu are no more than the plain search\n", equal, compared);
    assert_true(compared > 60);
    assert_true(equal >= compared * 9 / 10);
    free(measured);
    stp_chunk_destroy(&chunk);
}

/* A rough plane: random heights at random places, but one normal for all. */
static prep_cloud rough_plane(size_t count, double height)
{
    prep_cloud cloud = prep_cloud_make(count);
    for (size_t i = 0; i < count; i++) {
        cloud.points[i].position = (stp_dvec3){sqrt((double)count) * stp_random_unit(7, i),
                                               sqrt((double)count) * stp_random_unit(8, i),
                                               height * stp_random_unit(9, i)};
        cloud.points[i].normal.z = 1.0f;
    }
    return cloud;
}

static stp_dvec3 way_to_nearest(const stp_chunk *chunk, stp_dvec3 x)
{
    double least = INFINITY;
    stp_dvec3 way = {0.0, 0.0, 0.0};
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = 0; i < chunk->patches[p].counts[0]; i++) {
            stp_disc disc = disc_at(chunk, p, 0, i);
            stp_dvec3 v = stp_dvec3_sub(x, disc.centre);
            double height = stp_dvec3_dot(v, disc.normal);
            stp_dvec3 across = stp_dvec3_sub(v, stp_dvec3_scale(disc.normal, height));
            double length = stp_dvec3_length(across), out = fmax(0.0, length - disc.radius);
            if (hypot(height, out) >= least)
                continue;
            least = hypot(height, out);
            way = stp_dvec3_scale(disc.normal, height);
            if (out > 0.0)
                way = stp_dvec3_add(way, stp_dvec3_scale(across, out / length));
        }
    return way;
}

/* For one merged disc: the greatest distance, seen along a ray from 200 sides, between its points
 * and the points nearest to them, as a share of what the rule allows. */
static double worst_of_rays(const stp_chunk *chunk, uint32_t p, int level, uint32_t index,
                            unsigned q)
{
    const stp_patch *patch = &chunk->patches[p];
    const double e = stp_error_decode(stp_quarter_error(patch, level, q), patch->exponent);
    const double et =
        stp_error_decode(stp_quarter_tangential_error(patch, level, q), patch->exponent);
    const stp_dvec3 axis = stp_dvec3_from_float(stp_normal_decode(patch->cone_axis));
    const float cosine = (float)cos(stp_cone_angle_decode(patch->cone_angle));
    stp_dvec3 points[STP_DISC_POINTS];
    stp_disc merged = disc_at(chunk, p, level, index);
    unsigned count = stp_disc_points(&merged, points);
    double worst = 0.0;
    for (unsigned i = 0; i < count; i++) {
        stp_dvec3 way = way_to_nearest(chunk, points[i]);
        for (uint64_t k = 0; k < 200; k++) {
            double z = 1.0 - stp_random_unit(11, k), a = 2.0 * M_PI * stp_random_unit(12, k);
            double flat = sqrt(1.0 - z * z);
            stp_dvec3 ray = {flat * cos(a), flat * sin(a), z};
            float sine = stp_rule_sin_alpha((float)stp_dvec3_dot(ray, axis), cosine, 0.0f);
            stp_dvec3 seen = stp_dvec3_sub(way, stp_dvec3_scale(ray, stp_dvec3_dot(way, ray)));
            double said = (double)stp_rule_error(1.0f, sine, (float)e, (float)et);
            worst = fmax(worst, stp_dvec3_length(seen) / said);
        }
    }
    return worst;
}

/* The nearest point in space must also be as near on the screen as the rule says, from all sides.
 * This must hold even if the tangential error is small only because another disc lies under the
 * point. */
static void nearest_in_space_is_near_on_the_screen(void **state)
{
    (void)state;
    prep_cloud cloud = rough_plane(2500, 2.0);
    stp_chunk *chunk = build_chunk(&cloud);
    size_t discs = 0, broken = 0;
    double worst = 0.0;
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (int level = 1; level < STP_LEVEL_COUNT; level++)
            for (unsigned q = 0; q < (level == 3 ? 1 : chunk->patches[p].counts[2]); q++) {
                const uint8_t *counts = chunk->patches[p].counts;
                unsigned end = level == 3 ? 1 : stp_quarter_begin(counts, level, q + 1);
                unsigned i = level == 3 ? 0 : stp_quarter_begin(counts, level, q);
                for (; i < end; i++, discs++) {
                    double share = worst_of_rays(chunk, p, level, i, q);
                    broken += share > 1.0 + 1e-5;
                    worst = fmax(worst, share);
                }
            }
    print_message("%zu discs, %zu farther off than the rule says, by %.3f at most\n", discs, broken,
                  worst);
    assert_true(discs > 400);
    assert_int_equal(broken, 0);
    assert_true(worst > 0.7); /* the rule allows hardly more than there is */
    stp_chunk_destroy(&chunk);
}

/* A square grid of spacing 1. Inside, neighbours lie under every merged rim. At the grid's border
 * nothing does, and the rim reaches out by at most its own radius. */
static void only_a_border_hangs_over(void **state)
{
    (void)state;
    enum { SIDE = 96 };
    prep_cloud cloud = prep_cloud_make((size_t)SIDE * SIDE);
    for (uint32_t i = 0; i < SIDE * SIDE; i++)
        cloud.points[i].position = (stp_dvec3){i % SIDE, i / SIDE, 0.0};
    stp_chunk *chunk = build_chunk(&cloud);
    stp_overhang *measured = calloc(chunk->patch_count, sizeof *measured);
    stp_error err;
    assert_int_equal(stp_overhang_measure(measured, chunk, NULL, NULL, NULL, &err), STP_OK);
    double largest = 0.0;
    stp_dvec3 low = {INFINITY, INFINITY, 0.0}, high = {-INFINITY, -INFINITY, 0.0};
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = 0; i < chunk->patches[p].counts[0]; i++) {
            stp_disc d = disc_at(chunk, p, 0, i);
            low = (stp_dvec3){fmin(low.x, d.centre.x), fmin(low.y, d.centre.y), 0.0};
            largest = fmax(largest, d.radius);
            high = (stp_dvec3){fmax(high.x, d.centre.x), fmax(high.y, d.centre.y), 0.0};
        }
    size_t inside = 0, outside = 0;
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        stp_disc d = disc_at(chunk, p, STP_LEVEL_COUNT - 1, 0);
        double room = fmin(fmin(d.centre.x - low.x, d.centre.y - low.y),
                           fmin(high.x - d.centre.x, high.y - d.centre.y));
        double radius = stp_radius_decode(chunk->patches[p].radius[0], chunk->patches[p].exponent);
        double overhang = measured[p].level[STP_LEVEL_COUNT - 1];
        if (room > d.radius) {
            assert_true(overhang <= 1.1 * radius / STP_OVERHANG_PARTS); /* codes round up */
            inside++;
        } else {
            double beyond = d.radius - room - largest; /* reaches beyond the last row of discs */
            assert_true(overhang > beyond * 0.9);
            assert_true(overhang < d.radius);
            outside += beyond > 0.0;
        }
    }
    print_message("%zu patches inside, %zu hang over\n", inside, outside);
    assert_true(inside > 30);
    assert_true(outside > 10);
    free(measured);
    stp_chunk_destroy(&chunk);
}

static bool in_box(const stp_chunk_entry *e, stp_dvec3 world, double margin)
{
    stp_dvec3 p = stp_dvec3_sub(world, e->origin);
    return p.x > (double)e->box_min.x - margin && p.x < (double)e->box_max.x + margin &&
           p.y > (double)e->box_min.y - margin && p.y < (double)e->box_max.y + margin;
}

/* The same sheet in several leaves: at a leaf's border, the discs of other leaves lie under the
 * rim. */
static void other_chunks_carry_a_border(void **state)
{
    (void)state;
    enum { SIDE = 300 };
    prep_cloud cloud = prep_cloud_make((size_t)SIDE * SIDE);
    stp_prep_stats stats;
    for (uint32_t i = 0; i < SIDE * SIDE; i++)
        cloud.points[i].position = (stp_dvec3){i % SIDE, i / SIDE, 0.0};
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, NULL, &stats, NULL), STP_OK);
    stp_chunk_file *file = prep_open_verified(OUT);
    uint32_t count = stp_chunk_file_get_info(file)->chunk_count;
    stp_chunk_entry *entries = calloc(count, sizeof *entries);
    assert_non_null(entries);
    for (uint32_t id = 0; id < count; id++) {
        stp_chunk *chunk = prep_chunk(file, id, &entries[id]);
        stp_chunk_destroy(&chunk);
    }
    size_t inside = 0, at_border = 0;
    for (uint32_t id = 0; id < count; id++) {
        stp_chunk *chunk = prep_chunk(file, id, &entries[id]);
        for (uint32_t p = 0; p < chunk->patch_count && entries[id].child_count == 0; p++) {
            const stp_patch *patch = &chunk->patches[p];
            stp_disc d = disc_at(chunk, p, STP_LEVEL_COUNT - 1, 0);
            stp_dvec3 c = stp_dvec3_add(entries[id].origin, d.centre);
            double room = fmin(fmin(c.x, c.y), SIDE - 1.0 - fmax(c.x, c.y));
            if (room <= d.radius)
                continue;
            double stored = stp_error_decode(patch->tangential_error[3], patch->exponent);
            double radius = stp_radius_decode(patch->radius[0], patch->exponent);
            assert_true(stored <= 1.2 * radius / STP_OVERHANG_PARTS); /* codes round up */
            inside++;
            for (uint32_t other = 0; other < count; other++)
                at_border += other != id && entries[other].child_count == 0 &&
                             in_box(&entries[other], c, d.radius);
        }
        stp_chunk_destroy(&chunk);
    }
    print_message("%zu patches inside, %zu reach into other chunks\n", inside, at_border);
    assert_true(inside > 1000);
    assert_true(at_border > 20);
    free(entries);
    stp_chunk_file_close(&file);
    free(cloud.points);
}

static void threads_share_patches(void **state)
{
    (void)state;
    prep_cloud cloud = prep_cloud_wavy(20000, (stp_dvec3){3.0, -2.0, 1.0}, 1.0);
    stp_chunk *chunk = build_chunk(&cloud);
    stp_overhang *both[2];
    stp_pool *pool = NULL;
    assert_int_equal(stp_pool_create(&pool, 3, NULL), STP_OK);
    assert_true(chunk->patch_count > 100);
    for (int i = 0; i < 2; i++) {
        both[i] = calloc(chunk->patch_count, sizeof *both[i]);
        assert_int_equal(
            stp_overhang_measure(both[i], chunk, NULL, NULL, i == 0 ? NULL : pool, NULL), STP_OK);
    }
    assert_memory_equal(both[0], both[1], chunk->patch_count * sizeof *both[0]);
    stp_pool_destroy(&pool);
    free(both[0]);
    free(both[1]);
    stp_chunk_destroy(&chunk);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_with_a_plain_search),
        cmocka_unit_test(threads_share_patches),
        cmocka_unit_test(nearest_in_space_is_near_on_the_screen),
        cmocka_unit_test(only_a_border_hangs_over),
        cmocka_unit_test(other_chunks_carry_a_border),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
