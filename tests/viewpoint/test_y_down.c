/* Tests that clouds whose y points down, as photogrammetry has them, stand upright, and that
 * nothing else is turned. */
#include "tests/fixtures/first_view_fixture.h"

#include "base/earth.h"
#include "preprocess/viewpoint/first_view.h"
#include "preprocess/viewpoint/free_space.h"
#include "tests/fixtures/prep_fixture.h"

#include <math.h>

enum { GROUND = 6000, POINTS = GROUND + 3000 };

/* A ground of 6 x 4 with a ball over it, or with the ball below: a table, as far as levels tell.
 * down: y points down. */
static positions scene(stp_dvec3 *normals, bool ball_below, bool down)
{
    positions p = {0};
    const double sign = down ? -1.0 : 1.0, side = ball_below ? -1.0 : 1.0;
    for (uint64_t i = 0; i < GROUND; i++) {
        positions_add(&p, 6.0 * stp_random_unit(5, 2 * i), 0.0,
                      4.0 * stp_random_unit(5, 2 * i + 1));
        normals[i] = (stp_dvec3){0.0, sign, 0.0};
    }
    for (int i = 0; i < POINTS - GROUND; i++) {
        const stp_dvec3 d = stp_space_direction(i, POINTS - GROUND);
        positions_add(&p, 3.0 + 0.6 * d.x, sign * side * (0.9 + 0.6 * d.y), 2.0 + 0.6 * d.z);
        normals[GROUND + i] = (stp_dvec3){d.x, sign * side * d.y, d.z};
    }
    return p;
}

static void grounds_are_below(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        bool ball_below, down, normals;
        double up; /* y of what is up; 0: the points do not say */
    } cases[] = {
        {"y down", false, true, true, -1.0},
        {"y up", false, false, true, 0.0},
        {"a table, y up", true, false, true, 0.0},
        {"y down, without normals", false, true, false, 0.0},
    };
    stp_dvec3 normals[POINTS];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        positions p = scene(normals, cases[i].ball_below, cases[i].down);
        write_points("down.ply", &p, cases[i].normals ? normals : NULL);
        const stp_first_camera first = first_prep("down.ply", 2).first;
        if (first.model_up.y != cases[i].up || first.model_up.z != 0.0)
            fail_msg("%s: up is %g %g", cases[i].name, first.model_up.y, first.model_up.z);
        stp_chunk_file *file = prep_open_verified("first.stipple");
        const char *json = stp_chunk_file_get_info(file)->metadata_json;
        assert_int_equal(strstr(json, "\"up\":[0, -1, 0]") != NULL, cases[i].up < 0.0);
        stp_chunk_file_close(&file);
        free(p.at);
    }
}

/* The scene as Gaussian splats, with y and z exchanged if asked. */
static void write_splats(const char *path, const positions *p, bool z_up)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fprintf(file,
            "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
            "property float z\nproperty float f_dc_0\nproperty float f_dc_1\n"
            "property float f_dc_2\nend_header\n",
            POINTS);
    for (int i = 0; i < POINTS; i++) {
        const stp_dvec3 at = p->at[i];
        fprintf(file, "%.9g %.9g %.9g 0 0.5 1\n", at.x, z_up ? at.z : at.y, z_up ? at.y : at.z);
    }
    assert_int_equal(fclose(file), 0);
}

/* y of Gaussian splats points down, unless a ground says that z is up. */
static void splats_stand(void **state)
{
    (void)state;
    stp_dvec3 normals[POINTS];
    for (int z_up = 0; z_up < 2; z_up++) {
        positions p = scene(normals, false, z_up == 0);
        write_splats("splats.ply", &p, z_up);
        const stp_first_camera first = first_prep("splats.ply", 2).first;
        assert_true(first.model_up.y == (z_up ? 0.0 : -1.0));
        assert_true(!z_up || first.up.y == 0.0);
        free(p.at);
    }
}

/* A front of 20 x 15 with bays, seen from low y, whose normals point there: z is up. */
static void walls_stand(void **state)
{
    (void)state;
    positions p = {0};
    stp_dvec3 normals[POINTS];
    for (uint64_t i = 0; i < POINTS; i++) {
        const double x = 20.0 * stp_random_unit(6, 2 * i), z = 15.0 * stp_random_unit(6, 2 * i + 1);
        const bool out = fmod(x, 5.0) < 2.0 && fmod(z, 3.0) < 1.2;
        positions_add(&p, x, out ? 4.4 : 5.0, z);
        normals[i] = (stp_dvec3){0.0, -1.0, 0.0};
    }
    write_points("wall.ply", &p, normals);
    const stp_first_camera first = first_prep("wall.ply", 2).first;
    assert_true(first.model_up.z == 1.0 && first.why == STP_FIRST_SIDE);
    free(p.at);
}

/* A wall thin along z: a camera at the origin that looks along z faces it if normals point there;
 * else it may be ground, and about the origin or far above it is ground whose normals are wrong. */
static void cameras_face_walls(void **state)
{
    (void)state;
    enum { WALL, GROUND_BELOW, THICK, ABOUT, HIGH, KINDS };
    stp_dvec3 normals[POINTS];
    for (int kind = 0; kind < KINDS; kind++) {
        const bool wall = kind == WALL || kind == THICK;
        const double near = kind == THICK ? 1.0 : 1.44;
        const double shift = kind == ABOUT ? -1.2 : kind == HIGH ? 300.0 : 0.0;
        positions p = {0};
        for (uint64_t i = 0; i < POINTS; i++) {
            const double x = 2.0 * stp_random_unit(6, 2 * i);
            const double y = 1.5 * stp_random_unit(6, 2 * i + 1);
            positions_add(&p, 1.0 + x, 0.8 + y, (fmod(x, 0.5) < 0.2 ? near : 1.5) + shift);
            normals[i] = (stp_dvec3){0.0, 0.0, kind == GROUND_BELOW ? 1.0 : -1.0};
        }
        write_points("front.ply", &p, normals);
        const stp_first_camera first = first_prep("front.ply", 2).first;
        assert_true(first.why == (kind == WALL ? STP_FIRST_SIDE : STP_FIRST_WHOLE));
        assert_true(first.model_up.y == (wall ? -1.0 : 0.0));
        assert_true(kind != WALL || (first.eye.z < 0.0 && first.up.y < 0.0));
        free(p.at);
    }
}

/* Writes a level field, as text or as PCD that a scanner has seen from 30 m above a corner. */
static void level_field(const char *path, stp_dvec3 at, stp_dvec3 up, bool seen)
{
    const stp_dvec3 east = {-up.y, up.x, 0.0}, north = stp_dvec3_cross(up, east);
    const stp_dvec3 eye = stp_dvec3_add(at, stp_dvec3_scale(up, 30.0));
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    if (seen)
        fprintf(file,
                "VERSION .7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4000\n"
                "HEIGHT 1\nVIEWPOINT %.3f %.3f %.3f 1 0 0 0\nPOINTS 4000\nDATA ascii\n",
                eye.x, eye.y, eye.z);
    for (int i = 0; i < 4000; i++) {
        const stp_dvec3 p = stp_dvec3_add(
            at, stp_dvec3_add(stp_dvec3_scale(east, i % 80), stp_dvec3_scale(north, i / 80)));
        fprintf(file, "%.3f %.3f %.3f\n", p.x, p.y, p.z);
    }
    assert_int_equal(fclose(file), 0);
}

/* Coordinates about the earth's centre: up is away from it. Those of a map, as far away, are not.
 */
static void earth_is_below(void **state)
{
    (void)state;
    static const struct {
        stp_dvec3 at, up;
    } cases[] = {
        {{3833000.0, 884930.0, 5003000.0}, {0.6, 0.14, 0.788}},       /* 52 N 13 E */
        {{-3946000.0, 3430000.0, 3638000.0}, {-0.618, 0.537, 0.574}}, /* 35 N 139 E */
        {{550000.0, 6340000.0, 40.0}, {0.0, 0.0, 0.0}},               /* UTM, 57 N */
        {{3833000.0, 884930.0, 5103000.0}, {0.0, 0.0, 0.0}},          /* 79 km up */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const stp_dvec3 at = cases[i].at, size = {50.0, 80.0, 60.0};
        const stp_dbox box = {at, stp_dvec3_add(at, size)};
        const stp_dvec3 up = stp_dbox_earth_up(&box), away = stp_whole_direction_over(up);
        assert_true(stp_dvec3_length(stp_dvec3_sub(up, cases[i].up)) < 5e-3);
        assert_true(i > 1 || (stp_dvec3_dot(away, up) > 0.5 && away.z < 0.3));
        const stp_dvec3 front = stp_front(up); /* the south */
        assert_true(i > 1 || (fabs(stp_dvec3_dot(front, up)) < 1e-9 && front.z < -0.5 &&
                              fabs(stp_dvec3_length(front) - 1.0) < 1e-9));
    }
    level_field("earth.xyz", cases[0].at, cases[0].up, false);
    const stp_first_camera first = first_prep("earth.xyz", 2).first;
    assert_true(first.why == STP_FIRST_WHOLE && stp_dvec3_dot(first.model_up, cases[0].up) > 0.99);
    level_field("earth.pcd", cases[0].at, cases[0].up, true);
    const stp_first_camera seen = first_prep("earth.pcd", 2).first;
    assert_true(seen.why == STP_FIRST_SCANNER && stp_dvec3_dot(seen.up, cases[0].up) > 0.99 &&
                stp_dvec3_dot(seen.model_up, cases[0].up) > 0.99);
}

/* The whole model is seen from its front, from above, upright. */
static void seen_from_above(void **state)
{
    (void)state;
    const stp_dvec3 away = stp_whole_direction((stp_dvec3){0.0, -1.0, 0.0});
    assert_true(away.y < 0.0 && away.z < 0.0);
}

/* Inputs of several formats: heights are up before y is, and y before -y. */
static void formats_together(void **state)
{
    (void)state;
    static const struct {
        stp_prep_source source;
        stp_dvec3 up;
    } cases[] = {
        {{.heights = true, .y_up = true, .y_down = true}, {0.0, 0.0, 1.0}},
        {{.y_up = true, .y_down = true}, {0.0, 1.0, 0.0}},
        {{.y_down = true}, {0.0, -1.0, 0.0}},
    };
    const stp_dbox box = {{0.0, 0.0, 0.0}, {1.0, 1.0, 1000.0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_first_camera first = {0};
        assert_true(stp_dvec3_equal(stp_prep_told_up(&cases[i].source), cases[i].up));
        stp_first_view_of_heights(&first, &box, 0.0, 1.0, 0.999, &cases[i].source);
        assert_true(stp_dvec3_equal(first.up, cases[i].up));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(splats_stand),     cmocka_unit_test(grounds_are_below),
        cmocka_unit_test(walls_stand),      cmocka_unit_test(cameras_face_walls),
        cmocka_unit_test(earth_is_below),   cmocka_unit_test(seen_from_above),
        cmocka_unit_test(formats_together),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
