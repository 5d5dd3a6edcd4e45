/* Tests closed surfaces: what is proven of shapes whose insides are known, and what the file says
 * about it. */
#include "preprocess/closed/enclosure.h"
#include "preprocess/orient/orientation.h"
#include "tests/fixtures/surface_fixture.h"

#include <cjson/cJSON.h>
#include <string.h>

#define POINTS 60000u
static const stp_enclosure_params guessed = {.lambda = 1.7, .guessed = true};

/* How many points are closed; `wrong` counts those that point inwards or whose orientation is
 * unknown. */
typedef struct tally {
    uint32_t closed, wrong;
} tally;

static tally tally_of(const surface_cloud *s)
{
    tally t = {0};
    for (uint32_t i = 0; i < s->cloud.count; i++) {
        if (!(s->cloud.marks[i] & STP_MARK_CLOSED))
            continue;
        vec3s truth = s->truth[s->cloud.points[i].source].normal;
        t.closed++;
        t.wrong += glms_vec3_dot(stp_cloud_normal(&s->cloud, i), truth) <= 0.0f ||
                   !surface_is_oriented(s, i);
    }
    return t;
}

/* Removes the points in a ball and finds the surface of the rest. */
static surface_cloud scan_without(gen_shape shape, uint32_t count, stp_dvec3 middle, double radius)
{
    surface_cloud s = surface_scan(shape, count, 0.0, 0);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < s.cloud.count; i++)
        if (stp_dvec3_length(stp_dvec3_sub(s.cloud.points[i].position, middle)) > radius)
            s.cloud.points[kept++] = s.cloud.points[i];
    s.cloud.count = kept;
    surface_prepare(&s, 16);
    surface_orient(&s, (stp_orient_params){.mode = STP_ORIENT_PROPAGATE});
    return s;
}

static stp_outside find(surface_cloud *s)
{
    stp_outside out = {0};
    stp_error err = {0};
    assert_int_equal(stp_enclosure_find(&out, &s->cloud, &guessed, s->pool, &err), STP_OK);
    return out;
}

static void solids(void **state)
{
    static const gen_shape shapes[] = {GEN_SPHERE, GEN_TORUS, GEN_BUMPY, GEN_STATUE};
    (void)state;
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        /* some feathers are thinner than a voxel and enclose narrower gaps */
        const bool feathers = shapes[i] == GEN_STATUE;
        surface_cloud s =
            scan_without(shapes[i], feathers ? 5 * POINTS : POINTS, (stp_dvec3){0}, 0.0);
        stp_outside out = find(&s);
        tally t = tally_of(&s);
        print_message("shape %zu: %u of %u closed, %u wrong\n", i, t.closed,
                      (unsigned)s.cloud.count, t.wrong);
        assert_true(t.closed >= (feathers ? 0.9 : 1.0) * (double)s.cloud.count);
        assert_true(t.wrong <= (feathers ? 0.015 : 0.0) * (double)s.cloud.count);
        assert_int_equal(out.point_count, t.closed);
        stp_dvec3 middle = stp_dbox_middle(&s.cloud.box);
        double far = 10.0 * stp_dbox_side(&s.cloud.box);
        assert_true(stp_outside_holds(&out, (stp_dvec3){far, 0.0, 0.0}, 0.1 * far));
        if (shapes[i] != GEN_TORUS)
            assert_false(stp_outside_holds(&out, middle, 0.0));
        assert_false(stp_outside_holds(&out, middle, far));
        assert_false(stp_outside_holds(&out, (stp_dvec3){NAN, 0.0, 0.0}, 0.0));
        stp_outside_clear(&out);
        surface_clear(&s);
    }
}

static void open_surfaces(void **state)
{
    static const gen_shape shapes[] = {GEN_SHEET, GEN_TERRAIN, GEN_PLANE};
    (void)state;
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        surface_cloud s = scan_without(shapes[i], POINTS, (stp_dvec3){0}, 0.0);
        stp_outside out = find(&s);
        assert_int_equal(tally_of(&s).closed, 0);
        assert_int_equal(out.point_count, 0);
        for (uint32_t p = 0; p < s.cloud.count; p++)
            assert_false(surface_is_oriented(&s, p)); /* a guess never counts as known */
        stp_outside_clear(&out);
        surface_clear(&s);
    }
}

/* The distance of a ball's centre from the segment between two places. */
static double distance_to(stp_dvec3 centre, stp_dvec3 from, stp_dvec3 to)
{
    stp_dvec3 way = stp_dvec3_sub(to, from), at = stp_dvec3_sub(centre, from);
    double part = stp_dvec3_dot(at, way) / stp_dvec3_dot(way, way);
    part = stp_max(0.0, stp_min(1.0, part));
    return stp_dvec3_length(stp_dvec3_sub(at, stp_dvec3_scale(way, part)));
}

/* Every line of sight through a small hole must pass through one of the balls. A large hole leaves
 * nothing closed. */
static void holes(void **state)
{
    (void)state;
    for (int large = 0; large < 2; large++) {
        const stp_dvec3 top = {0.0, 0.0, 1.0};
        const double spacing = sqrt(4.0 * M_PI / POINTS);
        const double radius = (large ? 30.0 : 5.0) * spacing;
        surface_cloud s = scan_without(GEN_SPHERE, POINTS, top, radius);
        stp_outside out = find(&s);
        print_message("hole of %.1f spacings: %u closed, %u openings\n", radius / spacing,
                      tally_of(&s).closed, out.opening_count);
        assert_true(large ? out.point_count == 0
                          : tally_of(&s).closed > 0.97 * (double)s.cloud.count);
        assert_true(large || out.opening_count > 0);
        for (int ray = 0; !large && ray < 200; ray++) {
            double angle = 0.1 * ray, off = 0.8 * radius * sqrt(ray / 200.0);
            stp_dvec3 hole = {off * cos(angle), off * sin(angle), sqrt(1.0 - off * off)};
            stp_dvec3 eye = {sin(3.0 * angle), cos(2.0 * angle), 3.0};
            stp_dvec3 way = stp_dvec3_sub(hole, eye);
            bool through = false;
            for (uint32_t i = 0; i < out.opening_count; i++)
                through |= distance_to(out.openings[i].centre, eye,
                                       stp_dvec3_add(eye, stp_dvec3_scale(way, 1.3))) <=
                           out.openings[i].radius;
            assert_true(through);
        }
        stp_outside_clear(&out);
        surface_clear(&s);
    }
}

/* A sphere with more small holes than can be listed, 17 spacings apart. */
static surface_cloud sieve_make(void)
{
    enum { HOLES = 200 };
    const double radius = 2.6 * sqrt(4.0 * M_PI / POINTS);
    surface_cloud s = surface_scan(GEN_SPHERE, POINTS, 0.0, 0);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < s.cloud.count; i++) {
        double nearest = INFINITY;
        for (int h = 0; h < HOLES; h++) {
            const double z = (2.0 * h + 1.0) / HOLES - 1.0, turn = 2.399963 * h; /* golden angle */
            const double across = sqrt(1.0 - z * z);
            const stp_dvec3 hole = {across * cos(turn), across * sin(turn), z};
            nearest =
                stp_min(nearest, stp_dvec3_length(stp_dvec3_sub(s.cloud.points[i].position, hole)));
        }
        if (nearest > radius)
            s.cloud.points[kept++] = s.cloud.points[i];
    }
    s.cloud.count = kept;
    surface_prepare(&s, 16);
    surface_orient(&s, (stp_orient_params){.mode = STP_ORIENT_PROPAGATE});
    return s;
}

/* It is closed if voxels are twice as large: because there are many points, or because the holes
 * are too many. */
static void many_small_holes(void **state)
{
    static const uint64_t fine_points[] = {0, POINTS, POINTS / 2};
    (void)state;
    for (size_t i = 0; i < sizeof fine_points / sizeof *fine_points; i++) {
        surface_cloud s = sieve_make();
        stp_enclosure_params params = guessed;
        stp_outside out = {0};
        stp_error err = {0};
        params.fine_points = fine_points[i];
        assert_int_equal(stp_enclosure_find(&out, &s.cloud, &params, s.pool, &err), STP_OK);
        const tally t = tally_of(&s);
        print_message("%u closed, %u wrong, %u openings\n", t.closed, t.wrong, out.opening_count);
        assert_int_equal(t.wrong, 0);
        assert_true(i == 0 ? t.closed == 0 : t.closed > 0.99 * (double)s.cloud.count);
        stp_outside_clear(&out);
        surface_clear(&s);
    }
}

/* In a box too large for the voxels, nothing is closed, and no guess counts as known. */
static void too_large(void **state)
{
    (void)state;
    surface_cloud s = scan_without(GEN_SPHERE, POINTS, (stp_dvec3){0}, 0.0);
    const stp_dbox box = s.cloud.box;
    s.cloud.box.max.x += 1000.0;
    stp_outside out = find(&s);
    assert_int_equal(tally_of(&s).closed, 0);
    assert_int_equal(out.point_count, 0);
    for (uint32_t p = 0; p < s.cloud.count; p++)
        assert_false(surface_is_oriented(&s, p));
    s.cloud.box = box;
    out = find(&s);
    assert_int_equal(out.point_count, POINTS);
    stp_outside_clear(&out);
    surface_clear(&s);
}

/* A scan with fewer than 32,768 points is never closed. */
static void few_points(void **state)
{
    static const uint32_t counts[2] = {32767, 32768};
    (void)state;
    for (int i = 0; i < 2; i++) {
        surface_cloud s = scan_without(GEN_SPHERE, counts[i], (stp_dvec3){0}, 0.0);
        stp_outside out = {0};
        stp_error err = {0};
        assert_int_equal(stp_enclosure_find(&out, &s.cloud, &guessed, s.pool, &err), STP_OK);
        assert_int_equal(out.point_count, i == 0 ? 0 : counts[i]);
        stp_outside_clear(&out);
        surface_clear(&s);
    }
}

static void in_the_file(void **state)
{
    (void)state;
    uint8_t cubes[2 * 3 * 4];
    stp_opening opening = {{1.0, 2.0, 3.0}, 0.5};
    for (size_t i = 0; i < sizeof cubes; i++)
        cubes[i] = i % 5 == 3;
    const stp_outside in = {.point_count = 77,
                            .origin = {-1.0, 5.0, 1e6},
                            .cell = 0.25,
                            .cells = {2, 3, 4},
                            .outside = cubes,
                            .openings = &opening,
                            .opening_count = 1};
    cJSON *root = cJSON_CreateObject();
    cJSON_AddItemToObject(root, "closed", stp_outside_to_json(&in));
    char *text = cJSON_PrintUnformatted(root);
    stp_outside out = {0};
    stp_error err = {0};
    assert_int_equal(stp_outside_read(&out, text, strlen(text), &err), STP_OK);
    assert_int_equal(out.point_count, 77);
    assert_memory_equal(&out.origin, &in.origin, sizeof in.origin);
    assert_memory_equal(out.cells, in.cells, sizeof in.cells);
    assert_memory_equal(out.outside, cubes, sizeof cubes);
    assert_int_equal(out.opening_count, 1);
    assert_memory_equal(out.openings, &opening, sizeof opening);
    stp_outside_clear(&out);
    cJSON_Delete(root);
    cJSON_free(text);
}

static void malformed(void **state)
{
    static const char *const texts[] = {
        "{\"closed\":1}",
        "{\"closed\":{\"points\":1,\"origin\":[0,0,0],\"cell\":0,\"cells\":[1,1,1],\"outside\":[1]}"
        "}",
        "{\"closed\":{\"points\":0,\"origin\":[0,0,0],\"cell\":1,\"cells\":[1,1,1],\"outside\":[1]}"
        "}",
        "{\"closed\":{\"points\":1,\"origin\":[0,0],\"cell\":1,\"cells\":[1,1,1],\"outside\":[1]}}",
        "{\"closed\":{\"points\":1,\"origin\":[0,0,0],\"cell\":1,\"cells\":[1,1,257],\"outside\":["
        "1]}}",
        "{\"closed\":{\"points\":1,\"origin\":[0,0,0],\"cell\":1,\"cells\":[1,1,1],\"outside\":[2]}"
        "}",
        "{\"closed\":{\"points\":1,\"origin\":[0,0,0],\"cell\":1,\"cells\":[1,1,2],\"outside\":[1]}"
        "}",
        "{\"closed\":{\"points\":1,\"origin\":[0,0,0],\"cell\":1,\"cells\":[1,1,1],\"outside\":[-1,"
        "2]}}",
        "{\"closed\":{\"points\":1,\"origin\":[0,0,0],\"cell\":1,\"cells\":[1,1,1],\"outside\":[1],"
        "\"openings\":[[1,2,3]]}}",
        "{\"closed\":{\"points\":1,\"origin\":[0,0,0],\"cell\":1,\"cells\":[1,1,1],\"outside\":[1],"
        "\"openings\":{\"a\":1}}}",
    };
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        stp_outside out = {0};
        stp_error err = {0};
        assert_int_equal(stp_outside_read(&out, texts[i], strlen(texts[i]), &err), STP_CORRUPT);
        assert_null(out.outside);
        assert_non_null(strstr(err.message, "closed"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solids),     cmocka_unit_test(open_surfaces),
        cmocka_unit_test(holes),      cmocka_unit_test(too_large),
        cmocka_unit_test(few_points), cmocka_unit_test(in_the_file),
        cmocka_unit_test(malformed),  cmocka_unit_test(many_small_holes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
