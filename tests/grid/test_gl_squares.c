/* Tests squares of grids drawn as triangles, against rays that the test casts at the heights: every
 * pixel shows the surface of two triangles a cell, by each road; holes stay as wide as they are,
 * cliffs stay open; no seam opens within a grid that is bent, and no pixel on steep ground. Near
 * views of points and of triangles agree, and picks find the surface. test_gl_maps.c has elevation
 * maps. */
#include "runtime/camera/camera.h"
#include "runtime/camera/orbit.h"
#include "tests/fixtures/gl_model.h"
#include "tests/fixtures/prep_fixture.h"

enum { SIZE = 320, PIXELS = SIZE * SIZE, COLUMNS = 150, ROWS = 140 };
#define GRID_FILE "squares.stipple"

/* Samples are 1 apart; the top row has y = ROWS - 1. */
static const stp_scan_raster raster = {
    .columns = COLUMNS, .rows = ROWS, .x = 0.0, .y = ROWS - 1.0, .dx = 1.0, .dy = 1.0};

typedef double surface(double x, double y);

static double waves(double x, double y)
{
    return 2.0 * sin(x / 7.0) * cos(y / 9.0);
}

static double plateau(double x, double y)
{
    return x > 52.5 && x < 83.5 && y > 48.5 && y < 90.5 ? 30.0 : 0.0;
}

static bool is_missing(int column, int row)
{
    const bool wide = column >= 69 && column <= 73 && row >= 63 && row <= 65; /* over a border */
    const uint64_t i = (uint64_t)row * COLUMNS + (uint64_t)column;
    return wide || stp_random_unit(9, i) < 0.05;
}

static double heights[ROWS][COLUMNS]; /* of the last grid */

static prep_cloud make_grid(surface *height, bool holes)
{
    prep_cloud out = prep_cloud_make((size_t)COLUMNS * ROWS);
    out.raster = raster;
    for (int i = 0; i < COLUMNS * ROWS; i++) {
        const int column = i % COLUMNS, row = i / COLUMNS;
        const double x = column, y = raster.y - row;
        heights[row][column] = height(x, y);
        out.points[i].position = (stp_dvec3){x, y, heights[row][column]};
        out.points[i].normal = (vec3s){{0.0f, 0.0f, 1.0f}};
        out.points[i].reject =
            holes && is_missing(column, row) ? STP_REJECT_INVALID : STP_REJECT_NONE;
    }
    return out;
}

static void open_grid(gl_fixture *f, prep_cloud *cloud)
{
    stp_prep_stats stats;
    check_ok(prep_cloud_run(cloud, GRID_FILE, 2,
                            &(stp_prep_params){.codec = STP_CODEC_DRACO, .precision = 1e-3}, &stats,
                            err));
    assert_true(stats.keeps_grid);
    free(cloud->points);
    gl_fixture_open(f, GRID_FILE, NULL);
}

static stp_view look(const gl_fixture *f, stp_dvec3 eye, stp_dvec3 at, bool orthographic)
{
    stp_view view;
    const stp_camera camera = {.eye = eye,
                               .look = at,
                               .up = {0.0, 1.0, 0.0},
                               .fovy_deg = orthographic ? 0.0 : 40.0,
                               .height = orthographic ? 30.0 : 0.0};
    check_ok(stp_view_create(&view, &camera, &f->model->ball, SIZE, SIZE, err));
    return view;
}

/* Reads where the last picture has its surface; pixels that are empty have NaN. */
static void read_places(const gl_fixture *f, const stp_view *view, stp_dvec3 *out)
{
    static float depth[PIXELS];
    check_ok(stp_renderer_read_depth(f->renderer, depth, err));
    for (int i = 0; i < PIXELS; i++)
        out[i] = depth[i] > 0.0f
                     ? stp_view_unproject(view, i % SIZE + 0.5, i / SIZE + 0.5, (double)depth[i])
                     : (stp_dvec3){NAN, NAN, NAN};
}

static const stp_draw_params triangles = {.shade = STP_SHADE_UNLIT,
                                          .colour = STP_COLOUR_NONE,
                                          .grid_draw = STP_GRID_TRIANGLES,
                                          .every_sample = true};

/* ---- the surface ---- */

/* The height of the two triangles of a cell, which share the side from the next column's sample to
 * the next row's; NaN half a cell or more inside the border. */
static double height_at(double x, double y)
{
    const double c = floor(x), r = floor(raster.y - y), u = x - c, v = raster.y - y - r;
    if (!(c >= 1.0 && r >= 1.0 && c < COLUMNS - 2.0 && r < ROWS - 2.0))
        return NAN;
    const double(*h)[COLUMNS] = &heights[(int)r];
    const int k = (int)c;
    const double a = h[0][k], b = h[0][k + 1], d = h[1][k], e = h[1][k + 1];
    return u + v <= 1.0 ? a + u * (b - a) + v * (d - a)
                        : e + (1.0 - u) * (d - e) + (1.0 - v) * (b - e);
}

/* How far along the way between two places the ray meets the surface first; NaN: not, or beyond
 * the border. */
static double cast(stp_dvec3 from, stp_dvec3 to)
{
    const int steps = 1500;
    double before = NAN;
    for (int i = 0; i <= steps; i++) {
        const double t = i / (double)steps;
        const stp_dvec3 p = stp_dvec3_add(from, stp_dvec3_scale(stp_dvec3_sub(to, from), t));
        const double off = p.z - height_at(p.x, p.y);
        if (off <= 0.0)
            return before > 0.0 ? t - (1.0 / steps) * off / (off - before) : NAN;
        before = off;
    }
    return NAN;
}

/* Each pixel that a ray finds is covered, at its depth; none lies off the surface. */
static void check_surface(const gl_fixture *f, const stp_view *view, const char *what)
{
    static stp_dvec3 places[PIXELS];
    size_t hits = 0, open = 0, far = 0, off = 0;
    double worst = 0.0;
    read_places(f, view, places);
    for (int i = 0; i < PIXELS; i++) {
        const double u = i % SIZE + 0.5, v = i / SIZE + 0.5;
        const double z = height_at(places[i].x, places[i].y);
        off += fabs(places[i].z - z) > 0.01 ? 1u : 0u;
        worst = isnan(z) ? worst : fmax(worst, fabs(places[i].z - z));
        if (i % 17 != 0)
            continue;
        const stp_dvec3 from = stp_view_unproject(view, u, v, 1.0);
        const stp_dvec3 to = stp_view_unproject(view, u, v, 120.0);
        const double t = cast(from, to);
        if (isnan(t))
            continue;
        hits++;
        open += isnan(places[i].x) ? 1u : 0u;
        far += stp_dvec3_length(stp_dvec3_sub(places[i], from)) >
               t * stp_dvec3_length(stp_dvec3_sub(to, from)) + 0.1;
    }
    print_message("%s: %zu rays, %zu open, %zu seen behind; %zu pixels off, the worst by %g\n",
                  what, hits, open, far, off, worst);
    assert_true(hits > PIXELS / 34);
    assert_int_equal(open, 0);
    assert_int_equal(off, 0);
    assert_true(far <= hits / 1000); /* outlines */
}

static void every_pixel_shows_the_surface(void **state)
{
    (void)state;
    static const struct {
        const char *what;
        stp_lod lod;
    } roads[] = {{"compute", STP_LOD_COMPUTE},
                 {"geometry", STP_LOD_GEOMETRY},
                 {"cpu", STP_LOD_CPU},
                 {"full", STP_LOD_FULL}};
    static uint8_t first[4 * PIXELS], rgba[4 * PIXELS];
    gl_fixture f = {0};
    prep_cloud cloud = make_grid(waves, false);
    open_grid(&f, &cloud);
    for (int orthographic = 0; orthographic < 2; orthographic++) {
        const stp_view view =
            look(&f, (stp_dvec3){70.0, 30.0, 14.0}, (stp_dvec3){75.0, 62.0, 0.0}, orthographic);
        for (size_t k = 0; k < sizeof roads / sizeof *roads; k++) {
            stp_draw_params params = triangles;
            params.lod = roads[k].lod;
            gl_fixture_draw(&f, &view, &params, NULL, k ? rgba : first);
            check_surface(&f, &view, roads[k].what);
            if (k > 0)
                assert_memory_equal(rgba, first, sizeof first);
        }
    }
    gl_fixture_close(&f);
}

/* ---- holes and cliffs ---- */

/* Seen from above, a pixel near a sample's place is covered if and only if the sample is there. */
static void holes_keep_their_width(void **state)
{
    (void)state;
    static uint8_t rgba[4 * PIXELS];
    gl_fixture f = {0};
    prep_cloud cloud = make_grid(waves, true);
    open_grid(&f, &cloud);
    const stp_view view =
        look(&f, (stp_dvec3){71.0, 75.0, 40.0}, (stp_dvec3){71.0, 75.0, 0.0}, true);
    gl_fixture_draw(&f, &view, &triangles, NULL, rgba);
    size_t wrong[2] = {0, 0}, seen[2] = {0, 0};
    for (int i = 0; i < PIXELS; i++) {
        const stp_dvec3 p = stp_view_unproject(&view, i % SIZE + 0.5, i / SIZE + 0.5, 40.0);
        const double c = floor(p.x + 0.5), r = floor(raster.y - p.y + 0.5);
        if (fabs(p.x - c) > 0.33 || fabs(raster.y - p.y - r) > 0.33)
            continue;
        const bool missing = is_missing((int)c, (int)r);
        seen[missing]++;
        wrong[missing] += (rgba[4 * i + 3] == 0) != missing;
    }
    print_message("%zu pixels at samples, %zu open; %zu in holes, %zu closed\n", seen[0], wrong[0],
                  seen[1], wrong[1]);
    assert_true(seen[0] > 10000 && seen[1] > 500);
    assert_true(wrong[0] == 0 && wrong[1] == 0);
    gl_fixture_close(&f);
}

static void cliffs_stay_open(void **state)
{
    (void)state;
    static uint8_t rgba[4 * PIXELS];
    static stp_dvec3 places[PIXELS];
    gl_fixture f = {0};
    prep_cloud cloud = make_grid(plateau, false);
    open_grid(&f, &cloud);
    const stp_view view =
        look(&f, (stp_dvec3){68.0, 10.0, 70.0}, (stp_dvec3){68.0, 55.0, 15.0}, false);
    gl_fixture_draw(&f, &view, &triangles, NULL, rgba);
    read_places(&f, &view, places);
    size_t high = 0, low = 0, between = 0;
    for (int i = 0; i < PIXELS; i++) {
        high += fabs(places[i].z - 30.0) < 0.01;
        low += fabs(places[i].z) < 0.01;
        between += places[i].z >= 0.01 && places[i].z <= 29.99 ? 1u : 0u;
    }
    print_message("%zu pixels above, %zu below, %zu on the cliff\n", high, low, between);
    assert_true(high > 5000 && low > 5000 && between == 0);
    gl_fixture_close(&f);
}

/* ---- seams ---- */

static double even(double x, double y)
{
    return 0.01 * x + 0.02 * y;
}

/* Another coordinate system turns the columns by a quarter of a degree over the grid. */
static stp_dvec3 bend(double column, double row)
{
    const double angle = 3e-5 * column, radius = 33000.0 - row;
    return (stp_dvec3){radius * sin(angle), radius * cos(angle) - 32900.0, 0.0};
}

static void bent_grids_have_no_seams(void **state)
{
    (void)state;
    static uint8_t rgba[4 * PIXELS];
    static stp_dvec3 places[PIXELS], nodes[64];
    gl_fixture f = {0};
    prep_cloud cloud = make_grid(waves, false);
    const uint32_t across = stp_raster_node_count(COLUMNS), down = stp_raster_node_count(ROWS);
    assert_true(across * down <= 64);
    for (uint32_t i = 0; i < across * down; i++)
        nodes[i] = bend(stp_raster_node_column(i % across, COLUMNS),
                        stp_raster_node_column(i / across, ROWS));
    for (int i = 0; i < COLUMNS * ROWS; i++) {
        stp_dvec3 *p = &cloud.points[i].position;
        *p = bend(i % COLUMNS, i / COLUMNS);
        p->z = even(p->x, p->y);
    }
    cloud.raster_nodes = nodes;
    open_grid(&f, &cloud);
    const stp_view view =
        look(&f, (stp_dvec3){64.0, 36.0, 40.0}, (stp_dvec3){64.0, 36.0, 0.0}, true);
    gl_fixture_draw(&f, &view, &triangles, NULL, rgba);
    read_places(&f, &view, places);
    size_t open = 0;
    double worst = 0.0;
    for (int i = 0; i < PIXELS; i++) {
        open += isnan(places[i].x) ? 1u : 0u;
        worst = fmax(worst, fabs(places[i].z - even(places[i].x, places[i].y)));
    }
    print_message("bent: %zu pixels open, the worst off by %g\n", open, worst);
    assert_int_equal(open, 0);
    assert_true(worst < 0.01);
    gl_fixture_close(&f);
}

/* ---- where triangles begin ---- */

/* How many pixels are of triangles, and of points. */
static void count_primitives(const gl_fixture *f, const stp_view *view, stp_grid_draw draw,
                             size_t out[2])
{
    static uint8_t rgba[4 * PIXELS];
    const stp_draw_params params = {.shade = STP_SHADE_PRIMITIVE, .grid_draw = draw};
    gl_fixture_draw(f, view, &params, NULL, rgba);
    out[0] = out[1] = 0;
    for (int i = 0; i < PIXELS; i++) {
        out[0] += rgba[4 * i + 3] && rgba[4 * i] > rgba[4 * i + 2];
        out[1] += rgba[4 * i + 3] && rgba[4 * i] < rgba[4 * i + 2];
    }
}

static void triangles_are_for_near_samples(void **state)
{
    (void)state;
    gl_fixture f = {0};
    size_t near_by[3][2], far_off[3][2];
    prep_cloud cloud = make_grid(waves, false);
    open_grid(&f, &cloud);
    const stp_dvec3 at = {75.0, 70.0, 0.0};
    for (int draw = 0; draw < 3; draw++) {
        const stp_view near_view = look(&f, (stp_dvec3){75.0, 70.0, 40.0}, at, false);
        const stp_view far_view = look(&f, (stp_dvec3){75.0, 70.0, 300.0}, at, false);
        count_primitives(&f, &near_view, (stp_grid_draw)draw, near_by[draw]);
        count_primitives(&f, &far_view, (stp_grid_draw)draw, far_off[draw]);
    }
    assert_int_equal(near_by[STP_GRID_AUTO][0], PIXELS);
    assert_int_equal(near_by[STP_GRID_TRIANGLES][0], PIXELS);
    assert_int_equal(near_by[STP_GRID_POINTS][1], PIXELS);
    assert_int_equal(far_off[STP_GRID_AUTO][0], 0);
    assert_true(far_off[STP_GRID_AUTO][1] > PIXELS / 5);
    gl_fixture_close(&f);
}

/* A slope of 6 to 1, and noise of two cells. */
static double steep(double x, double y)
{
    const uint64_t i = (uint64_t)x + 1000u * (uint64_t)y;
    return 6.0 * y + 12.0 * (stp_random_unit(3, i) + stp_random_unit(4, i) - 1.0) / sqrt(6.0);
}

/* Triangles would take steps of steep, rough ground for cliffs. Its points close from near, too. */
static void steep_ground_is_closed(void **state)
{
    (void)state;
    static uint8_t rgba[4 * PIXELS];
    gl_fixture f = {0};
    prep_cloud cloud = make_grid(steep, false);
    open_grid(&f, &cloud);
    const stp_view view =
        look(&f, (stp_dvec3){75.0, -30.0, 436.0}, (stp_dvec3){75.0, 70.0, 420.0}, false);
    size_t open[2] = {0, 0};
    for (int k = 0; k < 2; k++) {
        const stp_draw_params params = {.grid_draw = k ? STP_GRID_TRIANGLES : STP_GRID_AUTO};
        gl_fixture_draw(&f, &view, &params, NULL, rgba);
        for (int y = 32; y < SIZE - 32; y++)
            for (int x = 32; x < SIZE - 32; x++)
                open[k] += rgba[4 * (y * SIZE + x) + 3] == 0 ? 1u : 0u;
    }
    print_message("steep ground: %zu pixels open, %zu as triangles\n", open[0], open[1]);
    assert_int_equal(open[0], 0);
    assert_true(open[1] > PIXELS / 100);
    gl_fixture_close(&f);
}

static double smooth(double x, double y)
{
    return 5.0 * y + sin(x / 7.0);
}

/* Smooth ground that steep has no step that looks like a cliff: it is drawn as triangles. */
static void smooth_steep_ground_is_triangles(void **state)
{
    (void)state;
    gl_fixture f = {0};
    size_t pixels[2];
    prep_cloud cloud = make_grid(smooth, false);
    open_grid(&f, &cloud);
    const stp_view view =
        look(&f, (stp_dvec3){75.0, -30.0, 436.0}, (stp_dvec3){75.0, 70.0, 420.0}, false);
    count_primitives(&f, &view, STP_GRID_AUTO, pixels);
    print_message("smooth steep ground: %zu pixels of triangles, %zu of points\n", pixels[0],
                  pixels[1]);
    assert_true(pixels[0] > PIXELS - PIXELS / 20 && pixels[1] < PIXELS / 1000);
    gl_fixture_close(&f);
}

/* Near the distance at which points give way to triangles, pictures of both agree. */
static void points_and_triangles_agree(void **state)
{
    (void)state;
    static uint8_t rgba[2][4 * PIXELS];
    gl_fixture f = {0};
    prep_cloud cloud = make_grid(waves, false);
    open_grid(&f, &cloud);
    const stp_view view =
        look(&f, (stp_dvec3){60.0, 20.0, 60.0}, (stp_dvec3){75.0, 62.0, 0.0}, false);
    for (int k = 0; k < 2; k++) {
        const stp_draw_params params = {.colour = STP_COLOUR_NONE,
                                        .every_sample = true,
                                        .grid_draw = k ? STP_GRID_TRIANGLES : STP_GRID_POINTS};
        gl_fixture_draw(&f, &view, &params, NULL, rgba[k]);
    }
    double sum = 0.0;
    size_t covered = 0, apart = 0;
    for (int i = 0; i < PIXELS; i++) {
        const double d = rgba[0][4 * i] - rgba[1][4 * i];
        apart += (rgba[0][4 * i + 3] == 0) != (rgba[1][4 * i + 3] == 0);
        covered += rgba[0][4 * i + 3] != 0 && rgba[1][4 * i + 3] != 0;
        sum += rgba[0][4 * i + 3] != 0 && rgba[1][4 * i + 3] != 0 ? d * d : 0.0;
    }
    const double psnr = 10.0 * log10(255.0 * 255.0 / fmax(sum / (double)covered, 1e-9));
    print_message("%g dB, %zu pixels covered by one alone\n", psnr, apart);
    assert_true(covered > PIXELS / 2 && psnr >= 38.0 && apart <= PIXELS / 1000);
    gl_fixture_close(&f);
}

/* How many finished pixels have a normal that points down, in the world; those that are covered. */
static size_t count_below(const gl_fixture *f, const stp_view *view, const stp_draw_params *params,
                          size_t *covered)
{
    static uint8_t rgba[4 * PIXELS];
    size_t below = 0;
    gl_fixture_draw(f, view, params, NULL, rgba);
    reference_pixel *pixels = gl_fixture_pixels(f, true);
    *covered = 0;
    for (int i = 0; i < PIXELS; i++) {
        const stp_dvec3 n = pixels[i].normal;
        const double z = n.x * view->right.z + n.y * view->up.z + n.z * view->back.z;
        *covered += pixels[i].tag != 0;
        below += pixels[i].tag != 0 && z < 0.0;
    }
    free(pixels);
    return below;
}

/* Behind a crest, samples lean away from a low eye. They must be lit like the crest, from above.
 * From under the grid, all of it is lit from below. */
static void crests_are_lit_from_above(void **state)
{
    (void)state;
    gl_fixture f = {0};
    size_t covered;
    prep_cloud cloud = make_grid(waves, false);
    open_grid(&f, &cloud);
    for (int cull = 0; cull < 2; cull++)
        for (int draw = 0; draw < 2; draw++) {
            const stp_draw_params params = {.keep_pixels = true,
                                            .cull = cull ? STP_CULL_NONE : STP_CULL_AUTO,
                                            .grid_draw = draw ? STP_GRID_POINTS : STP_GRID_AUTO};
            stp_camera camera = {.eye = {2.0, 2.0, 6.0},
                                 .look = {80.0, 90.0, 0.0},
                                 .up = {0.0, 0.0, 1.0},
                                 .fovy_deg = 40.0};
            stp_view view;
            check_ok(stp_view_create(&view, &camera, &f.model->ball, SIZE, SIZE, err));
            const size_t below = count_below(&f, &view, &params, &covered);
            assert_true(below <= 4); /* such as lean by more; if all were turned: 34 and 166 */
            assert_true(covered > PIXELS / 3);
            camera.eye.z = -6.0;
            check_ok(stp_view_create(&view, &camera, &f.model->ball, SIZE, SIZE, err));
            assert_true(count_below(&f, &view, &params, &covered) > covered - covered / 20);
            assert_true(covered > PIXELS / 3);
        }
    gl_fixture_close(&f);
}

static void picks_find_the_surface(void **state)
{
    (void)state;
    static uint8_t rgba[4 * PIXELS];
    gl_fixture f = {0};
    prep_cloud cloud = make_grid(waves, false);
    open_grid(&f, &cloud);
    const stp_view view =
        look(&f, (stp_dvec3){70.0, 30.0, 14.0}, (stp_dvec3){75.0, 62.0, 0.0}, false);
    gl_fixture_draw(&f, &view, &triangles, NULL, rgba);
    for (int k = 0; k < 300; k++) {
        stp_pick pick;
        check_ok(stp_renderer_pick(f.renderer, (int)(SIZE * stp_random_unit(1, (uint64_t)k)),
                                   (int)(0.7 * SIZE * stp_random_unit(2, (uint64_t)k)), &pick,
                                   err));
        assert_true(pick.hit && !pick.interpolated && pick.level == 0);
        assert_int_not_equal(pick.chunk, STP_PICK_NO_CHUNK);
        const double z = height_at(pick.position.x, pick.position.y);
        assert_true(fabs(pick.position.z - z) < 0.01);
    }
    gl_fixture_close(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pixel_shows_the_surface),
        cmocka_unit_test(holes_keep_their_width),
        cmocka_unit_test(cliffs_stay_open),
        cmocka_unit_test(bent_grids_have_no_seams),
        cmocka_unit_test(triangles_are_for_near_samples),
        cmocka_unit_test(steep_ground_is_closed),
        cmocka_unit_test(smooth_steep_ground_is_triangles),
        cmocka_unit_test(points_and_triangles_agree),
        cmocka_unit_test(crests_are_lit_from_above),
        cmocka_unit_test(picks_find_the_surface),
    };
    stp_gl_context *context = gl_fixture_context();
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stp_gl_context_destroy(&context);
    return failed;
}
