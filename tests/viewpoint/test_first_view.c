/* Tests first views: which positions of scanners are believed, and from where a model is first
 * seen. Real scans: tests/support/real_scans.sh. */
#include "base/sort.h"
#include "tests/fixtures/first_view_fixture.h"

#include "preprocess/viewpoint/free_space.h"
#include "preprocess/viewpoint/seen_from.h"
#include "runtime/camera/camera.h"
#include "tests/fixtures/prep_fixture.h"

#define ORIGIN ((stp_dvec3){0.0, 0.0, 0.0})
#define Z_AXIS ((stp_dvec3){0.0, 0.0, 1.0})

static stp_view view_of(const stp_first_camera *first, int width, int height)
{
    const stp_camera camera = {
        .eye = first->eye, .look = first->look, .up = first->up, .fovy_deg = first->fovy_deg};
    const stp_ball ball = {first->look, 10.0};
    stp_view view;
    assert_int_equal(stp_view_create(&view, &camera, &ball, width, height, NULL), STP_OK);
    return view;
}

/* Each point must project to its own pixel of the camera's image. */
static void expect_image(const stp_first_camera *first, const positions *p, const depth_camera *c)
{
    const stp_view view = view_of(first, (int)c->width, (int)c->height);
    double *off = malloc(p->count * sizeof *off);
    size_t count = 0;
    assert_non_null(off);
    assert_int_equal(first->why, STP_FIRST_SCANNER);
    for (size_t i = 0; i < p->count; i++) {
        if (!stp_dvec3_finite(p->at[i]))
            continue;
        const stp_dvec3 at = stp_view_project(&view, p->at[i]);
        assert_true(at.z > 0.0);
        off[count++] = hypot(at.x - ((double)(i % c->width) + 0.5),
                             at.y - ((double)(c->height - 1 - i / c->width) + 0.5));
    }
    stp_sort_doubles(off, count);
    if (!(off[count / 2] < 0.25 && off[count - 1] < 1.0))
        fail_msg("pixels are off by %g, at most %g", off[count / 2], off[count - 1]);
    free(off);
}

static stp_prep_stats prep_depth(const positions *p, size_t height, const char *viewpoint)
{
    depth_write("depth.pcd", p, height, viewpoint);
    return first_prep("depth.pcd", 2);
}

/* Points in the camera's own axes: with the default viewpoint, and with any quaternion. */
static void images_about_the_origin(void **state)
{
    (void)state;
    static const char *const viewpoints[] = {NULL, "0 0 0 1 0 0 0", "0 0 0 0 1 0 0"};
    positions p = depth_image(&depth_small, false, ORIGIN, Z_AXIS, 0.0);
    for (size_t i = 0; i < 3; i++) {
        const stp_prep_stats stats = prep_depth(&p, depth_small.height, viewpoints[i]);
        expect_image(&stats.first, &p, &depth_small);
        assert_true(stp_dvec3_equal(stats.first.eye, ORIGIN));
        assert_int_equal(stats.orientation, STP_ORIENTATION_POSITION);
        assert_int_equal(stats.stations_refused, 0);
    }
    free(p.at);
}

/* Points in the world's axes: the right position is believed; the origin and a wrong position are
 * not. */
static void images_in_the_world(void **state)
{
    (void)state;
    const stp_dvec3 place = {103.0, -52.0, 7.5}, axis = {0.6, 0.7, -0.3};
    positions p = depth_image(&depth_small, false, place, axis, 2.1);
    stp_prep_stats stats = prep_depth(&p, depth_small.height, "103 -52 7.5 1 0 0 0");
    expect_image(&stats.first, &p, &depth_small);
    assert_int_equal(stats.orientation, STP_ORIENTATION_POSITION);
    stats = prep_depth(&p, depth_small.height, "0 0 0 1 0 0 0");
    assert_int_equal(stats.first.why, STP_FIRST_WHOLE);
    assert_int_not_equal(stats.orientation, STP_ORIENTATION_POSITION);
    assert_int_equal(stats.stations_refused, 0);
    assert_int_equal(stats.points_unstationed, 0);
    stats = prep_depth(&p, depth_small.height, "103.3 -52 7.5 1 0 0 0");
    assert_int_equal(stats.first.why, STP_FIRST_WHOLE);
    assert_int_not_equal(stats.orientation, STP_ORIENTATION_POSITION);
    assert_int_equal(stats.stations_refused, 1);
    free(p.at);
}

/* Rows from bottom to top: the picture must still be upright. */
static void rows_may_go_up(void **state)
{
    (void)state;
    positions p = depth_image(&depth_small, false, ORIGIN, Z_AXIS, 0.0), up = {0};
    for (size_t row = depth_small.height; row-- > 0;)
        for (size_t column = 0; column < depth_small.width; column++) {
            const stp_dvec3 at = p.at[row * depth_small.width + column];
            positions_add(&up, at.x, at.y, at.z);
        }
    const stp_prep_stats stats = prep_depth(&up, depth_small.height, NULL);
    expect_image(&stats.first, &p, &depth_small);
    free(up.at);
    free(p.at);
}

/* A plane alone supports no position; a claimed position may still be used. */
static void a_wall_says_nothing(void **state)
{
    (void)state;
    positions p = depth_image(&depth_small, true, ORIGIN, Z_AXIS, 0.0);
    stp_prep_stats stats = prep_depth(&p, depth_small.height, "0 0 0 1 0 0 0");
    assert_int_equal(stats.first.why, STP_FIRST_WHOLE);
    stats = prep_depth(&p, depth_small.height, "0 0 0 0 1 0 0");
    expect_image(&stats.first, &p, &depth_small);
    free(p.at);
}

/* Points without rows: a camera at the origin is found because nothing hides its points. A camera
 * elsewhere is not found. */
static void points_without_rows(void **state)
{
    (void)state;
    const depth_camera fine = {320, 240, 280.0, 160.0, 120.0};
    positions p = depth_image(&fine, false, ORIGIN, Z_AXIS, 0.0);
    stp_prep_stats stats = prep_depth(&p, 1, "0 0 0 1 0 0 0");
    assert_int_equal(stats.first.why, STP_FIRST_SCANNER);
    assert_int_equal(stats.orientation, STP_ORIENTATION_POSITION);
    assert_true(stp_dvec3_equal(stats.first.eye, ORIGIN));
    assert_true(stats.first.up.y < -0.9); /* a depth camera's y points down */
    const stp_view view = view_of(&stats.first, 320, 240);
    for (size_t i = 0; i < p.count; i += 97) {
        const stp_dvec3 at = stp_view_project(&view, p.at[i]);
        assert_true(!stp_dvec3_finite(p.at[i]) ||
                    (at.z > 0.0 && fabs(at.x - 160.0) < 190.0 && fabs(at.y - 120.0) < 140.0));
    }
    for (size_t i = 0; i < p.count; i++)
        p.at[i].x += 1.0;
    stats = prep_depth(&p, 1, "0 0 0 1 0 0 0");
    assert_int_equal(stats.first.why, STP_FIRST_WHOLE);
    assert_int_not_equal(stats.orientation, STP_ORIENTATION_POSITION);
    stats = prep_depth(&p, 1, "1 0 0 1 0 0 0");
    assert_int_equal(stats.first.why, STP_FIRST_SCANNER);
    free(p.at);
}

/* The 0 0 0 of a survey is no scanner, whether it lies far from the points or among them. */
static void surveys_at_the_origin(void **state)
{
    (void)state;
    const stp_dvec3 middles[] = {{513000.0, 5403000.0, 300.0}, {0.0, 0.0, 0.0}, {10.0, 5.0, -30.0}};
    for (size_t i = 0; i < sizeof middles / sizeof *middles; i++) {
        positions p = survey(middles[i]);
        const stp_prep_stats stats = prep_depth(&p, 1, "0 0 0 1 0 0 0");
        if (stats.first.why != STP_FIRST_WHOLE || stats.orientation == STP_ORIENTATION_POSITION)
            fail_msg("survey %zu is seen from the origin", i);
        free(p.at);
    }
}

/* ---- images of parallel rays ---- */

/* A range image of a dome, 40 x 30 millimetres; its rows go upwards. */
static void parallel_rays(void **state)
{
    (void)state;
    const size_t columns = 80, rows = 60;
    FILE *file = fopen("range.ply", "w");
    size_t count = 0;
    assert_non_null(file);
    for (int pass = 0; pass < 3; pass++) {
        if (pass == 1)
            fprintf(file,
                    "ply\nformat ascii 1.0\nobj_info num_cols %zu\nobj_info num_rows %zu\n"
                    "element vertex %zu\nproperty float x\nproperty float y\nproperty float z\n"
                    "element range_grid %zu\nproperty list uchar int vertex_indices\nend_header\n",
                    columns, rows, count, columns * rows);
        if (pass > 0)
            count = 0;
        for (size_t i = 0; i < columns * rows; i++) {
            const double x = 0.5 * (double)(i % columns) - 20.0;
            const double y = 0.5 * (double)(i / columns) - 15.0;
            const double square = x * x + y * y / 0.5;
            if (square < 400.0 && pass == 1)
                fprintf(file, "%g %g %g\n", x, y, 0.5 * sqrt(400.0 - square));
            if (pass == 2 && square < 400.0)
                fprintf(file, "1 %zu\n", count);
            else if (pass == 2)
                fprintf(file, "0\n");
            count += square < 400.0;
        }
    }
    fclose(file);
    const stp_first_camera first = first_prep("range.ply", 2).first;
    const stp_dvec3 forward = stp_dvec3_normalize(stp_dvec3_sub(first.look, first.eye));
    assert_int_equal(first.why, STP_FIRST_SCANNER);
    assert_true(forward.z < -0.99);
    assert_true(first.up.y > 0.99);
    const stp_view view = view_of(&first, 400, 300);
    assert_true(fabs(stp_view_project(&view, (stp_dvec3){0.0, 0.0, 10.0}).x - 200.0) < 5.0);
    assert_true(stp_view_project(&view, (stp_dvec3){0.0, 14.0, 0.0}).y <= 301.0);
    assert_true(stp_view_project(&view, (stp_dvec3){0.0, 14.0, 0.0}).y > 250.0);
}

/* ---- scanners with a known position ---- */

/* A scan of a room's walls from inside, by a tilted scanner. The wall at high x is the largest
 * surface that it sees. */
static void scanners_that_look_around(void **state)
{
    (void)state;
    FILE *file = fopen("around.ptx", "w");
    const double lean = 0.1, s = sin(lean), c = cos(lean);
    const stp_dvec3 up = {s, 0.0, c};
    positions p = {0};
    assert_non_null(file);
    room_box(&p, (stp_dvec3){-1.0, -1.0, -1.0}, (stp_dvec3){1.0, 1.0, 1.0}, 2u);
    room_face(&p, (stp_dvec3){6.0, -8.0, -3.0}, (stp_dvec3){0.0, 16.0, 0.0},
              (stp_dvec3){0.0, 0.0, 8.0});
    fprintf(
        file,
        "%zu\n1\n50 60 70\n%g 0 %g\n0 1 0\n%g 0 %g\n%g 0 %g 0\n0 1 0 0\n%g 0 %g 0\n50 60 70 1\n",
        p.count, c, -s, s, c, c, -s, s, c);
    for (size_t i = 0; i < p.count; i++) { /* into the scanner's axes */
        const stp_dvec3 v = p.at[i];
        fprintf(file, "%.9g %.9g %.9g 0.5\n", c * v.x - s * v.z, v.y, s * v.x + c * v.z);
    }
    fclose(file);
    const stp_first_camera first = first_prep("around.ptx", 2).first;
    const stp_dvec3 forward = stp_dvec3_normalize(stp_dvec3_sub(first.look, first.eye));
    assert_int_equal(first.why, STP_FIRST_SCANNER);
    assert_true(stp_dvec3_equal(first.eye, (stp_dvec3){50.0, 60.0, 70.0}));
    assert_true(stp_dvec3_dot(first.up, up) > 0.9999);
    assert_true(forward.x > 0.9);
    assert_true(first.look.x > 55.0); /* the pivot lies on the wall */
    free(p.at);
}

/* A range map with the camera that took it. */
static void range_maps_with_a_camera(void **state)
{
    (void)state;
    positions p = depth_image(&depth_small, false, (stp_dvec3){5.0, 6.0, 7.0},
                              (stp_dvec3){1.0, 0.0, 0.0}, 0.4);
    FILE *file = fopen("map.ply", "w");
    size_t count = 0;
    assert_non_null(file);
    for (size_t i = 0; i < p.count; i++)
        count += stp_dvec3_finite(p.at[i]);
    fprintf(file,
            "ply\nformat ascii 1.0\nelement camera 1\nproperty float view_px\n"
            "property float view_py\nproperty float view_pz\nproperty float y_axisx\n"
            "property float y_axisy\nproperty float y_axisz\nproperty float focal\n"
            "element vertex %zu\nproperty float x\nproperty float y\nproperty float z\n"
            "end_header\n5 6 7 0 %g %g 14\n",
            count, -cos(0.4), -sin(0.4));
    for (size_t i = 0; i < p.count; i++)
        if (stp_dvec3_finite(p.at[i]))
            fprintf(file, "%.9g %.9g %.9g\n", p.at[i].x, p.at[i].y, p.at[i].z);
    fclose(file);
    const stp_prep_stats stats = first_prep("map.ply", 2);
    const stp_view view = view_of(&stats.first, 160, 120);
    assert_int_equal(stats.first.why, STP_FIRST_SCANNER);
    assert_int_equal(stats.orientation, STP_ORIENTATION_POSITION);
    assert_true(stp_dvec3_equal(stats.first.eye, (stp_dvec3){5.0, 6.0, 7.0}));
    /* the image's first row must be above its last, its first column left of its last */
    const stp_dvec3 first = stp_view_project(&view, p.at[0]);
    const stp_dvec3 last = stp_view_project(&view, p.at[p.count - 1]);
    assert_true(first.y > last.y + 90.0 && first.x < last.x - 120.0);
    free(p.at);
}

/* ---- interiors ---- */

/* Checks in the room's own axes: the eye stands free and upright, and looks along the room. */
static void expect_inside(const stp_first_camera *first, const positions *room, stp_dvec3 axis,
                          double angle)
{
    const stp_dvec3 eye = stp_dvec3_rotate(first->eye, axis, -angle);
    const stp_dvec3 look = stp_dvec3_rotate(first->look, axis, -angle);
    const stp_dvec3 up = stp_dvec3_rotate(first->up, axis, -angle);
    const stp_dvec3 forward = stp_dvec3_normalize(stp_dvec3_sub(look, eye));
    double nearest = INFINITY;
    assert_int_equal(first->why, STP_FIRST_INTERIOR);
    for (size_t i = 0; i < room->count; i++)
        nearest = fmin(nearest, stp_dvec3_length(stp_dvec3_sub(room->at[i], first->eye)));
    assert_true(nearest > 0.4);
    assert_true(fabs(eye.x - 10.0) < 2.0 && fabs(eye.y - 20.0) < 1.3);
    assert_true(eye.z > 0.7 && eye.z < 1.9);
    assert_true(up.z > 0.999);
    assert_true(fabs(forward.x) > 0.75);
    assert_true(fabs(forward.z) < 0.2);
    /* it must look at a wall */
    assert_true(fmin(fabs(look.x - 7.0), fabs(look.x - 13.0)) < 0.3 ||
                fmin(fabs(look.y - 18.0), fabs(look.y - 22.0)) < 0.3);
    assert_true(first->fovy_deg >= 70.0 && first->fovy_deg <= 75.0);
}

static void rooms_are_seen_from_inside(void **state)
{
    (void)state;
    const stp_dvec3 axes[] = {{0.0, 0.0, 1.0}, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}};
    const double angles[] = {0.0, 0.5, -M_PI / 2.0}; /* the last: y points up */
    for (int furnished = 0; furnished < 2; furnished++)
        for (size_t i = 0; i < 3; i++) {
            positions p = room_scan(furnished > 0);
            room_turn(&p, axes[i], angles[i]);
            write_points("room.ply", &p, NULL);
            const stp_first_camera first = first_prep("room.ply", 2).first;
            expect_inside(&first, &p, axes[i], angles[i]);
            free(p.at);
        }
}

/* A small room as phones scan it, with y up, has little more floor and ceiling than walls, but its
 * furniture tells. A high and narrow corridor has more wall than floor, and still z up. */
static void furniture_stands_on_the_floor(void **state)
{
    (void)state;
    for (int z_up = 0; z_up < 2; z_up++) {
        positions p = {0};
        room_box(&p, (stp_dvec3){0.0, 0.0, 0.0},
                 z_up ? (stp_dvec3){9.0, 2.2, 2.8} : (stp_dvec3){5.0, 2.6, 4.0}, 0);
        room_box(&p, (stp_dvec3){1.5, z_up ? 0.6 : 0.0, z_up ? 0.0 : 1.0},
                 z_up ? (stp_dvec3){3.0, 1.4, 0.75} : (stp_dvec3){3.0, 0.75, 2.0}, 0);
        room_box(&p, (stp_dvec3){z_up ? 6.0 : 0.5, z_up ? 0.4 : 0.0, z_up ? 0.0 : 2.6},
                 z_up ? (stp_dvec3){7.0, 0.9, 1.2} : (stp_dvec3){1.3, 2.0, 3.6}, 0);
        write_points("room.ply", &p, NULL);
        const stp_first_camera first = first_prep("room.ply", 2).first;
        assert_int_equal(first.why, STP_FIRST_INTERIOR);
        assert_true((z_up ? first.up.z : first.up.y) > 0.9);
        free(p.at);
    }
}

/* The file's normals decide: an egg with outward normals is seen from outside, and with inward
 * normals from inside, though no room has its shape. */
static void given_normals_decide(void **state)
{
    (void)state;
    for (int sign = -1; sign <= 1; sign += 2) {
        positions p = {0};
        stp_dvec3 *normals = malloc(40000 * sizeof *normals);
        assert_non_null(normals);
        for (size_t i = 0; i < 40000; i++) {
            const double z = 2.0 * stp_random_unit(31, i) - 1.0;
            const double a = 2.0 * M_PI * stp_random_unit(32, i), across = sqrt(1.0 - z * z);
            positions_add(&p, 4.0 * across * cos(a), 3.0 * across * sin(a), 2.0 * z);
            normals[i] =
                stp_dvec3_scale(stp_dvec3_normalize((stp_dvec3){across * cos(a) / 4.0,
                                                                across * sin(a) / 3.0, z / 2.0}),
                                sign);
        }
        write_points("egg.ply", &p, normals);
        assert_int_equal(first_prep("egg.ply", 2).first.why,
                         sign < 0 ? STP_FIRST_INTERIOR : STP_FIRST_WHOLE);
        free(normals);
        free(p.at);
    }
}

/* These are no interiors: balls, a cube, a crate's four walls, hills, a cloud of leaves, a closed
 * house in a garden. */
static void objects_are_seen_whole(void **state)
{
    (void)state;
    for (int kind = 0; kind < 6; kind++) {
        positions p = {0};
        if (kind == 5)
            room_box(&p, (stp_dvec3){-6.0, -4.0, 0.0}, (stp_dvec3){6.0, 4.0, 6.0}, 0);
        for (size_t i = 0; i < 20000 && kind == 5; i++)
            positions_add(&p, 44.0 * stp_random_unit(44, i) - 22.0,
                          44.0 * stp_random_unit(45, i) - 22.0, 0.05 * stp_random_unit(46, i));
        if (kind == 1)
            room_box(&p, (stp_dvec3){-1.0, -1.0, -1.0}, (stp_dvec3){1.0, 1.0, 1.0}, 0);
        if (kind == 2)
            room_box(&p, (stp_dvec3){-2.0, -1.0, -1.0}, (stp_dvec3){2.0, 1.0, 1.0}, 32u | 16u);
        if (kind == 3)
            p = survey((stp_dvec3){40.0, 0.0, 100.0});
        for (size_t i = 0; i < 40000 && (kind == 0 || kind == 4); i++) {
            const double z = 2.0 * stp_random_unit(41, i) - 1.0;
            const double a = 2.0 * M_PI * stp_random_unit(42, i);
            const double r = kind == 0 ? 1.0 : cbrt(stp_random_unit(43, i));
            const double across = r * sqrt(1.0 - z * z);
            positions_add(&p, across * cos(a), 0.8 * across * sin(a), 0.6 * r * z);
        }
        write_points("object.ply", &p, NULL);
        if (first_prep("object.ply", 2).first.why != STP_FIRST_WHOLE)
            fail_msg("kind %d is not seen whole", kind);
        free(p.at);
    }
}

/* A flat object and a few points far away: these must not make the object a speck. They may lie 2
 * sizes away, then all is seen. In map coordinates z is up. */
static void strays_are_not_the_view(void **state)
{
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        const double far = kind < 2 ? 1e4 : 2.0;
        const stp_dvec3 at = kind % 2 ? (stp_dvec3){4e5, 5e6, 10.0} : (stp_dvec3){3.0, -2.0, 10.0};
        positions p = {0};
        for (size_t i = 0; i < 20000; i++)
            positions_add(&p, at.x + stp_random_unit(51, i), at.y + 0.2 * stp_random_unit(52, i),
                          at.z + stp_random_unit(53, i));
        for (size_t i = 0; i < 40; i++)
            positions_add(&p, at.x - far * stp_random_unit(54, i), at.y,
                          at.z + far * stp_random_unit(55, i));
        write_points("strays.ply", &p, NULL);
        const stp_first_camera first = first_prep("strays.ply", 2).first;
        assert_int_equal(first.why, kind < 2 ? STP_FIRST_MAIN : STP_FIRST_WHOLE);
        if (kind < 2) {
            const stp_view view = view_of(&first, 100, 100);
            double low = 100.0, high = 0.0;
            for (size_t i = 0; i < 20000; i++) {
                const stp_dvec3 seen = stp_view_project(&view, p.at[i]);
                assert_true(seen.z > 0.0 && fabs(seen.x - 50.0) < 50.0);
                low = fmin(low, seen.y);
                high = fmax(high, seen.y);
            }
            assert_true(low > 0.0 && high < 100.0 && high - low > 20.0);
            assert_true(first.up.z == (kind == 1 ? 1.0 : 0.0));
        }
        free(p.at);
    }
}

/* Two objects so far apart that both would be specks: the one with more points is seen. In rows,
 * objects are seen together. */
static void far_parts_are_not_the_view(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; kind++) { /* 1: not so far; 2: a few points are no part */
        const double far = kind == 1 ? 9.0 : 3000.0;
        positions p = {0};
        room_box(&p, (stp_dvec3){-0.4, -0.3, 0.0}, (stp_dvec3){0.4, 0.3, 1.6}, 0);
        const size_t larger = p.count;
        room_box(&p, (stp_dvec3){far - 0.2, -0.2, 0.0}, (stp_dvec3){far + 0.2, 0.2, 1.2}, 0);
        for (size_t i = 0; i < 12 && kind == 2; i++)
            p.at[i] = p.at[i < 8 ? 3 * i : larger + i];
        p.count = kind == 2 ? 12 : p.count;
        write_points("parts.ply", &p, NULL);
        const stp_first_camera first = first_prep("parts.ply", 2).first;
        assert_int_equal(first.why, kind == 0 ? STP_FIRST_PART : STP_FIRST_WHOLE);
        for (size_t i = 0; i < larger && kind == 0; i++) {
            const stp_view view = view_of(&first, 100, 100);
            const stp_dvec3 seen = stp_view_project(&view, p.at[i]);
            assert_true(seen.z > 0.0 && seen.z < 5.0 && fabs(seen.x - 50.0) < 50.0 &&
                        fabs(seen.y - 50.0) < 50.0);
        }
        free(p.at);
    }
}

/* A corridor around a corner has no enclosed place near the middle of its box. */
static void corridors_are_seen_from_inside(void **state)
{
    (void)state;
    positions p = {0};
    room_box(&p, (stp_dvec3){0.0, 0.0, 0.0}, (stp_dvec3){12.0, 2.0, 2.6}, 8u);
    room_box(&p, (stp_dvec3){0.0, 2.0, 0.0}, (stp_dvec3){2.0, 12.0, 2.6}, 4u);
    room_face(&p, (stp_dvec3){2.0, 2.0, 0.0}, (stp_dvec3){10.0, 0.0, 0.0},
              (stp_dvec3){0.0, 0.0, 2.6});
    write_points("corner.ply", &p, NULL);
    const stp_first_camera first = first_prep("corner.ply", 2).first;
    assert_int_equal(first.why, STP_FIRST_INTERIOR);
    assert_true(fmin(first.eye.x, first.eye.y) > 0.5 && fmin(first.eye.x, first.eye.y) < 1.5);
    assert_true(first.eye.z > 0.7 && first.eye.z < 1.9);
    assert_true(first.up.z > 0.999);
    assert_true(stp_dvec3_length(stp_dvec3_sub(first.look, first.eye)) > 3.0);
    free(p.at);
}

/* An egg on a broad base, alone or in a row: what it stands on tells what is up. Of an egg alone,
 * its length does. */
static void what_things_stand_on_is_below(void **state)
{
    (void)state;
    const stp_dvec3 x_axis = {1.0, 0.0, 0.0};
    for (int kind = 0; kind < 6; kind++) {
        const bool turned = kind % 2 > 0; /* y is up */
        positions p = {0};
        for (int i = 0; i < (kind < 2 ? 1 : 3) && (kind < 4 || i < 1); i++) {
            const double x = 4.0 * i;
            if (kind < 4)
                room_box(&p, (stp_dvec3){x - 0.7, -0.6, 0.0}, (stp_dvec3){x + 0.7, 0.6, 0.15}, 0);
            for (int k = 0; k < 4000; k++) {
                const stp_dvec3 d = stp_space_direction(k, 4000);
                positions_add(&p, x + 0.45 * d.x, 0.45 * d.y, 0.95 + 0.8 * d.z);
            }
        }
        room_turn(&p, x_axis, turned ? -M_PI / 2.0 : 0.0);
        write_points("stands.ply", &p, NULL);
        const stp_first_camera first = first_prep("stands.ply", 2).first;
        assert_int_equal(first.why, STP_FIRST_WHOLE);
        if (first.model_up.z != (turned ? 0.0 : 1.0) || first.model_up.y != 0.0)
            fail_msg("kind %d: up is %g %g %g", kind, first.model_up.x, first.model_up.y,
                     first.model_up.z);
        stp_chunk_file *file = prep_open_verified("first.stipple");
        const char *json = stp_chunk_file_get_info(file)->metadata_json;
        assert_int_equal(strstr(json, "\"up\":[0, 0, 1]") != NULL, !turned);
        stp_chunk_file_close(&file);
        free(p.at);
    }
}

/* ---- the file ---- */

/* Any number of threads must give the same bytes, with the camera in the metadata. */
static void the_file_says_it(void **state)
{
    (void)state;
    positions p = room_scan(true);
    uint8_t *bytes[2] = {NULL, NULL};
    size_t size[2];
    write_points("room.ply", &p, NULL);
    for (int run = 0; run < 2; run++) {
        first_prep("room.ply", run == 0 ? 1 : 4);
        bytes[run] = prep_file_bytes("first.stipple", &size[run]);
    }
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    stp_chunk_file *file = prep_open_verified("first.stipple");
    const char *json = stp_chunk_file_get_info(file)->metadata_json;
    assert_non_null(strstr(json, "\"first_view\":{\"eye\":["));
    assert_non_null(strstr(json, "\"why\":\"interior\""));
    stp_chunk_file_close(&file);
    free(bytes[0]);
    free(bytes[1]);
    free(p.at);
}

/* Few points, points on a line, or all points at one place. */
static void odd_clouds(void **state)
{
    (void)state;
    const double sizes[] = {0.0, 1e-12, 1.0, 1e6};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (size_t count = 1; count <= 1000; count = 10 * count) {
            positions p = {0};
            for (size_t i = 0; i < count; i++)
                positions_add(&p, sizes[s] * (double)i, sizes[s] * (double)(i % 7), 0.0);
            prep_depth(&p, 1, "0 0 0 1 0 0 0");
            prep_depth(&p, 1, "1 2 3 1 0 0 0");
            if (count % 10 == 0 && sizes[s] > 0.0) /* at the origin all would be holes */
                prep_depth(&p, 10, "0 0 0 1 0 0 0");
            free(p.at);
        }
}

/* The share of one wall that another hides: all of it from the front, nothing from between the
 * two. */
static void hidden_shares(void **state)
{
    (void)state;
    positions p = {0};
    double before, between;
    for (size_t i = 0; i < 20000; i++)
        positions_add(&p, stp_random_unit(51, i) - 0.5, stp_random_unit(52, i) - 0.5,
                      i % 2 ? 2.0 : 3.0);
    assert_int_equal(stp_hidden_share(&before, p.at, (uint32_t)p.count, ORIGIN, NULL), STP_OK);
    assert_int_equal(
        stp_hidden_share(&between, p.at, (uint32_t)p.count, (stp_dvec3){0.0, 0.0, 2.5}, NULL),
        STP_OK);
    assert_true(before > 0.4 && before < 0.51);
    assert_true(between < 0.05);
    free(p.at);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_about_the_origin),
        cmocka_unit_test(images_in_the_world),
        cmocka_unit_test(rows_may_go_up),
        cmocka_unit_test(a_wall_says_nothing),
        cmocka_unit_test(points_without_rows),
        cmocka_unit_test(surveys_at_the_origin),
        cmocka_unit_test(parallel_rays),
        cmocka_unit_test(scanners_that_look_around),
        cmocka_unit_test(range_maps_with_a_camera),
        cmocka_unit_test(rooms_are_seen_from_inside),
        cmocka_unit_test(furniture_stands_on_the_floor),
        cmocka_unit_test(given_normals_decide),
        cmocka_unit_test(objects_are_seen_whole),
        cmocka_unit_test(strays_are_not_the_view),
        cmocka_unit_test(far_parts_are_not_the_view),
        cmocka_unit_test(corridors_are_seen_from_inside),
        cmocka_unit_test(what_things_stand_on_is_below),
        cmocka_unit_test(the_file_says_it),
        cmocka_unit_test(odd_clouds),
        cmocka_unit_test(hidden_shares),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
