/* Tests first views of things that are flat, and of streets, whose axes nothing tells. */
#include "tests/fixtures/first_view_fixture.h"

#include "runtime/camera/camera.h"
#include "tests/fixtures/prep_fixture.h"

#define WIDTH 160
#define HEIGHT 120

static const stp_dvec3 x_axis = {1.0, 0.0, 0.0}, y_axis = {0.0, 1.0, 0.0}, z_axis = {0.0, 0.0, 1.0};

/* A wall of 4 x 2 along x and z with a relief along y. */
static positions wall_of(void)
{
    positions p = {0};
    for (uint64_t i = 0; i < 6000; i++) {
        const double x = 4.0 * stp_random_unit(7, 2 * i), z = 2.0 * stp_random_unit(7, 2 * i + 1);
        positions_add(&p, x, 0.05 * sin(9.0 * x) * sin(7.0 * z), z);
    }
    return p;
}

static stp_first_camera seen(positions *p, stp_dvec3 normal)
{
    stp_dvec3 *normals = malloc(p->count * sizeof *normals);
    assert_non_null(normals);
    for (size_t i = 0; i < p->count; i++)
        normals[i] = normal;
    write_points("side.ply", p, stp_dvec3_length(normal) > 0.0 ? normals : NULL);
    free(normals);
    return first_prep("side.ply", 2).first;
}

/* All points are in a picture of 4 x 3, and reach from one of its edges nearly to the other. */
static void expect_full(const stp_first_camera *first, const positions *p, const char *name)
{
    const stp_camera made = {
        .eye = first->eye, .look = first->look, .up = first->up, .fovy_deg = first->fovy_deg};
    const stp_camera camera = stp_camera_widened(&made, first->aspect, WIDTH, HEIGHT);
    const stp_ball ball = {first->look, 10.0};
    double least = 1e9, most = -1e9;
    stp_view view;
    assert_int_equal(stp_view_create(&view, &camera, &ball, WIDTH, HEIGHT, NULL), STP_OK);
    for (size_t i = 0; i < p->count; i++) {
        const stp_dvec3 at = stp_view_project(&view, p->at[i]);
        if (!(at.x > 0.0 && at.x < WIDTH && at.y > 0.0 && at.y < HEIGHT))
            fail_msg("%s: a point is at %g %g of the picture", name, at.x, at.y);
        least = fmin(least, at.x);
        most = fmax(most, at.x);
    }
    if (most - least < 0.8 * WIDTH)
        fail_msg("%s: %g of %d columns are used", name, most - least, WIDTH);
}

/* Whatever the axes of the file, a wall is seen from its broad side, upright, and fills the
 * picture. */
static void walls_are_seen_from_their_broad_side(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        stp_dvec3 axis;
        double angle;
        bool y_up;
    } walls[] = {
        {"thin along y", {0.0, 0.0, 1.0}, 0.0, false},
        {"thin along x", {0.0, 0.0, 1.0}, M_PI / 2.0, false},
        {"askew", {0.0, 0.0, 1.0}, 0.6, false},
        {"askew, y up", {0.0, 1.0, 0.0}, 0.7, true},
    };
    for (size_t i = 0; i < sizeof walls / sizeof *walls; i++)
        for (int side = -1; side <= 1; side++) { /* which way its normals point; 0: it has none */
            positions p = wall_of();
            stp_dvec3 out = y_axis;
            if (walls[i].y_up) { /* stands along x and y first */
                room_turn(&p, x_axis, -M_PI / 2.0);
                out = stp_dvec3_rotate(out, x_axis, -M_PI / 2.0);
            }
            room_turn(&p, walls[i].axis, walls[i].angle);
            out = stp_dvec3_rotate(out, walls[i].axis, walls[i].angle);
            const stp_first_camera first = seen(&p, stp_dvec3_scale(out, side));
            const stp_dvec3 away = stp_dvec3_normalize(stp_dvec3_sub(first.eye, first.look));
            const double along = stp_dvec3_dot(away, out);
            if (first.why != STP_FIRST_SIDE || fabs(along) < 0.85 || side * along < 0.0)
                fail_msg("%s, %d: seen for reason %d, %g along the normal", walls[i].name, side,
                         first.why, along);
            assert_true(stp_dvec3_dot(first.up, walls[i].y_up ? y_axis : z_axis) == 1.0);
            assert_true(stp_dvec3_dot(first.model_up, first.up) == 1.0);
            expect_full(&first, &p, walls[i].name);
            free(p.at);
        }
}

/* What is thin along z, or thick, is seen as before. */
static void ground_and_boxes_are_seen_whole(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        positions p = {0};
        if (kind == 0) {
            p = wall_of();
            room_turn(&p, x_axis, M_PI / 2.0);
        } else {
            room_box(&p, (stp_dvec3){0.0, 0.0, 0.0}, (stp_dvec3){4.0, 1.0, 2.0}, 0);
        }
        assert_int_not_equal(seen(&p, (stp_dvec3){0.0, 0.0, 0.0}).why, STP_FIRST_SIDE);
        free(p.at);
    }
}

/* A street between houses: its ground is below, though the walls are level along y, too. */
static void streets_stand_on_their_ground(void **state)
{
    (void)state;
    positions p = {0};
    for (uint64_t i = 0; i < 30000; i++) {
        const double x = 60.0 * stp_random_unit(3, 3 * i), u = stp_random_unit(3, 3 * i + 1);
        const int part = (int)(3.0 * stp_random_unit(3, 3 * i + 2));
        positions_add(&p, x,
                      part == 0   ? 14.0 * u
                      : part == 1 ? 0.0
                                  : 14.0,
                      part == 0 ? 0.0 : 12.0 * u);
    }
    const stp_first_camera first = seen(&p, (stp_dvec3){0.0, 0.0, 0.0});
    assert_true(first.model_up.z == 1.0);
    free(p.at);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(walls_are_seen_from_their_broad_side),
        cmocka_unit_test(ground_and_boxes_are_seen_whole),
        cmocka_unit_test(streets_stand_on_their_ground),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
