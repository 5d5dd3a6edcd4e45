/* Tests the normals of depth images against the surfaces that the images show. */
#include "base/sort.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/orient/pixel_sheets.h"
#include "preprocess/surface/image_normals.h"
#include "tests/fixtures/first_view_fixture.h"

#define PLACE ((stp_dvec3){500000.0, -20.0, 7.0})
#define AXIS ((stp_dvec3){0.3, -0.8, 0.5})
#define ANGLE 0.7

/* The camera's errors: 1 / depth in steps, and a Gaussian deviation. */
typedef struct depth_noise {
    double step, deviation;
} depth_noise;

typedef struct image_case {
    const char *name;
    depth_noise noise;
    bool leaning;     /* a wall along the view instead of the scene */
    double mean, p95; /* degrees, at most */
} image_case;

static double degrees(double radians)
{
    return radians * 180.0 / M_PI;
}

static double scene_depth(const image_case *c, double x, double y)
{
    return c->leaning ? 8.0 / (1.0 + 2.2 * (x + 0.6)) : depth_scene(x, y, false);
}

static stp_dvec3 scene_point(const image_case *c, double x, double y)
{
    const double z = scene_depth(c, x, y);
    return (stp_dvec3){x * z, y * z, z};
}

/* The true normal; false at edges, where normals a few pixels away differ. */
static bool scene_normal(const image_case *c, double x, double y, stp_dvec3 *out)
{
    const double h = 1e-4, reach = 5.0 / depth_small.focal;
    for (int side = 0; side < 5; side++) {
        const double u = x + (side == 1 ? reach : side == 2 ? -reach : 0.0);
        const double v = y + (side == 3 ? reach : side == 4 ? -reach : 0.0);
        const stp_dvec3 p = scene_point(c, u, v);
        const stp_dvec3 a = stp_dvec3_sub(scene_point(c, u + h, v), p);
        const stp_dvec3 b = stp_dvec3_sub(scene_point(c, u, v + h), p);
        const stp_dvec3 n = stp_dvec3_normalize(stp_dvec3_cross(b, a));
        if (!stp_dvec3_finite(n) || (side > 0 && !(stp_dvec3_dot(n, *out) > 0.9)))
            return false;
        if (side == 0)
            *out = n;
    }
    return true;
}

static stp_dvec3 turned(stp_dvec3 v)
{
    return stp_dvec3_rotate(v, stp_dvec3_normalize(AXIS), ANGLE);
}

static double gauss(uint64_t i)
{
    return sqrt(-2.0 * log(stp_random_unit(5, i) + 1e-12)) *
           cos(2.0 * M_PI * stp_random_unit(6, i));
}

/* Makes a cloud of the image's points; each point's source is its pixel. */
static stp_cloud make_image(const image_case *c, const depth_camera *camera)
{
    stp_cloud cloud;
    stp_error err;
    const uint32_t pixels = (uint32_t)(camera->width * camera->height);
    assert_int_equal(stp_cloud_create(&cloud, 0, pixels, NULL, &err), STP_OK);
    for (uint32_t i = 0; i < pixels; i++) {
        const double x = ((double)(i % camera->width) - camera->cx) / camera->focal;
        const double y = (double)(i / camera->width) - camera->cy;
        double inverse = 1.0 / scene_depth(c, x, y / camera->focal);
        if (!isfinite(inverse))
            continue;
        inverse += c->noise.deviation * gauss(i);
        if (c->noise.step > 0.0)
            inverse = c->noise.step * round(inverse / c->noise.step);
        const stp_dvec3 p = {x / inverse, y / camera->focal / inverse, 1.0 / inverse};
        cloud.points[cloud.count++] =
            (stp_cloud_point){.position = stp_dvec3_add(PLACE, turned(p)), .source = i};
    }
    return cloud;
}

static uint64_t find(stp_cloud *cloud, const stp_scan_grid *grid, unsigned threads)
{
    const stp_file_points points = {.cloud = cloud, .begin = 0, .end = cloud->count};
    stp_pool *pool = NULL;
    stp_error err;
    uint64_t count = 0;
    assert_int_equal(stp_pool_create(&pool, threads, &err), STP_OK);
    assert_int_equal(stp_image_normals(&points, grid, PLACE, pool, &count, &err), STP_OK);
    stp_pool_destroy(&pool);
    return count;
}

static const stp_scan_grid small_grid = {.columns = 160, .rows = 120};

/* Checks the angles to the true surfaces, away from edges. */
static void expect_normals(const image_case *c)
{
    stp_cloud cloud = make_image(c, &depth_small);
    double *off = malloc(cloud.count * sizeof *off), sum = 0.0;
    size_t count = 0, judged = 0;
    assert_non_null(off);
    find(&cloud, &small_grid, 2);
    for (uint32_t i = 0; i < cloud.count; i++) {
        const stp_cloud_point *p = &cloud.points[i];
        stp_dvec3 truth = {0.0, 0.0, 0.0};
        if (!scene_normal(c, (p->source % 160 - depth_small.cx) / depth_small.focal,
                          ((double)(p->source / 160) - depth_small.cy) / depth_small.focal, &truth))
            continue;
        judged++;
        if (!p->given)
            continue;
        const double cosine = stp_dvec3_dot(stp_dvec3_from_float(p->normal), turned(truth));
        off[count] = degrees(acos(fmin(cosine, 1.0)));
        sum += off[count++];
    }
    assert_true(judged > cloud.count / 2);
    assert_true((double)count >= 0.85 * (double)judged); /* the box lies within one step */
    stp_sort_doubles(off, count);
    const double mean = sum / (double)count, p95 = off[count * 95 / 100];
    print_message("%s: %.2f degrees, 95 %% within %.2f\n", c->name, mean, p95);
    if (!(mean <= c->mean && p95 <= c->p95))
        fail_msg("%s: normals are off by %g degrees, 95 %% by at most %g", c->name, mean, p95);
    free(off);
    stp_cloud_clear(&cloud);
}

/* The steps are 3 spacings of the wall, so the nearest points in space lie on one step. Without the
 * mean of neighbours each case is off by more. */
static void noise_along_rays(void **state)
{
    (void)state;
    static const image_case cases[] = {
        {"steps", {.step = 0.006}, false, 0.5, 1.2},
        {"steps and noise", {.step = 0.006, .deviation = 0.003}, false, 1.3, 5.2},
        {"noise", {.deviation = 0.003}, false, 1.1, 4.3},
        {"leaning, steps", {.step = 0.006}, true, 0.5, 1.1},
        {"leaning, wide steps", {.step = 0.02}, true, 0.7, 2.0},
        {"leaning, noise", {.deviation = 0.002}, true, 0.3, 0.6},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        expect_normals(&cases[i]);
}

/* Which of the scene's surfaces a point lies on: 0 wall, 1 ball, 2 box. */
static unsigned surface_of(const stp_cloud_point *p)
{
    const double depth = scene_depth(
        &(image_case){.name = "scene"}, (p->source % 160 - depth_small.cx) / depth_small.focal,
        ((double)(p->source / 160) - depth_small.cy) / depth_small.focal);
    return depth == 2.6 ? 2 : depth < 2.6 ? 1 : 0;
}

/* Gives each point of an image a sheet of its own, as if each step of the camera were one, and
 * joins the sheets by the image. */
static stp_cloud join_pixels(const image_case *c)
{
    stp_cloud cloud = make_image(c, &depth_small);
    const stp_prep_file file = {.point_count = 160 * 120, .station_count = 1, .grid = small_grid};
    const stp_dvec3 station = PLACE;
    const stp_prep_source source = {.files = &file, .file_count = 1, .stations = &station};
    find(&cloud, &small_grid, 2);
    cloud.sheets = malloc(cloud.count * sizeof *cloud.sheets);
    cloud.marks = calloc(cloud.count, sizeof *cloud.marks);
    assert_true(cloud.sheets && cloud.marks);
    for (uint32_t i = 0; i < cloud.count; i++)
        cloud.sheets[i] = i;
    assert_int_equal(stp_pixel_sheets_join(&cloud, &source, NULL), STP_OK);
    return cloud;
}

/* Layers of one surface become one sheet; surfaces before each other stay apart. */
static void layers_join(void **state)
{
    (void)state;
    static const image_case cases[] = {{"steps", {.step = 0.006}, false, 0.0, 0.0},
                                       {"noise", {.deviation = 0.003}, false, 0.0, 0.0}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        stp_cloud cloud = join_pixels(&cases[k]);
        uint32_t(*of)[3] = calloc(cloud.count, sizeof *of), all[3] = {0}, most[3] = {0};
        assert_non_null(of);
        for (uint32_t i = 0; i < cloud.count; i++) {
            const unsigned s = surface_of(&cloud.points[i]);
            all[s]++;
            of[cloud.sheets[i]][s]++;
        }
        for (uint32_t i = 0; i < cloud.count; i++) {
            const uint32_t sum = of[i][0] + of[i][1] + of[i][2];
            for (unsigned s = 0; s < 3; s++) {
                most[s] = of[i][s] > most[s] ? of[i][s] : most[s];
                /* Pixels at an edge may go with either. */
                assert_true(of[i][s] == 0 || of[i][s] == sum || of[i][s] * 50 < sum ||
                            (sum - of[i][s]) * 50 < sum);
            }
        }
        print_message("%s: largest sheets %u of %u, %u of %u, %u of %u\n", cases[k].name, most[0],
                      all[0], most[1], all[1], most[2], all[2]);
        for (unsigned s = 0; s < 3; s++)
            assert_true(most[s] * 10 > all[s] * 8);
        free(of);
        stp_cloud_clear(&cloud);
    }
}

/* Normals of exact points, and given normals, must stay as they are. */
static void leaves_alone(void **state)
{
    (void)state;
    const image_case exact = {.name = "exact"}, noisy = {.name = "noisy", .noise = {.step = 0.006}};
    stp_cloud cloud = make_image(&exact, &depth_small);
    assert_int_equal(find(&cloud, &small_grid, 1), 0);
    stp_cloud_clear(&cloud);
    cloud = make_image(&noisy, &depth_small);
    for (uint32_t i = 0; i < cloud.count; i++) {
        cloud.points[i].given = STP_GIVEN_INPUT;
        cloud.points[i].normal = (vec3s){{0.0f, 1.0f, 0.0f}};
    }
    assert_int_equal(find(&cloud, &small_grid, 1), 0);
    for (uint32_t i = 0; i < cloud.count; i++)
        assert_true(cloud.points[i].normal.y == 1.0f);
    stp_cloud_clear(&cloud);
}

/* Any number of threads, and a file that names its pixels, must give the same normals. */
static void the_same_again(void **state)
{
    (void)state;
    const image_case noisy = {.name = "noisy", .noise = {.step = 0.006}};
    stp_cloud one = make_image(&noisy, &depth_small), other = make_image(&noisy, &depth_small);
    stp_grid_cell *cells = malloc(one.count * sizeof *cells);
    assert_non_null(cells);
    for (uint32_t i = 0; i < other.count; i++) {
        cells[i] = (stp_grid_cell){i, (uint32_t)(other.points[i].source % 160),
                                   (uint32_t)(other.points[i].source / 160)};
        other.points[i].source = i;
    }
    const stp_scan_grid named = {160, 120, cells, (uint32_t)other.count};
    assert_int_equal(find(&one, &small_grid, 1), find(&other, &named, 3));
    for (uint32_t i = 0; i < one.count; i++)
        assert_memory_equal(&one.points[i].normal, &other.points[i].normal, sizeof(vec3s));
    free(cells);
    stp_cloud_clear(&one);
    stp_cloud_clear(&other);
}

/* Grids too large for so few points, grids of one row or column, and points at the station. */
static void no_image(void **state)
{
    (void)state;
    static const stp_scan_grid grids[] = {
        {.columns = UINT32_MAX, .rows = UINT32_MAX},
        {.columns = UINT32_MAX, .rows = 1},
        {.columns = 1, .rows = 160 * 120},
        {.columns = 160 * 120, .rows = 1},
        {.columns = 160, .rows = 0},
    };
    const image_case noisy = {.name = "noisy", .noise = {.step = 0.006}};
    for (size_t i = 0; i < sizeof grids / sizeof *grids; i++) {
        stp_cloud cloud = make_image(&noisy, &depth_small);
        assert_int_equal(find(&cloud, &grids[i], 1), 0);
        for (uint32_t p = 0; p < cloud.count; p++)
            cloud.points[p].position = PLACE;
        assert_int_equal(find(&cloud, &small_grid, 1), 0);
        stp_cloud_clear(&cloud);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_along_rays), cmocka_unit_test(layers_join),
        cmocka_unit_test(leaves_alone),     cmocka_unit_test(the_same_again),
        cmocka_unit_test(no_image),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
