/* Tests elevation maps drawn as a mesh, as splats and as points, against rays that the test casts
 * at the true surface, a ball with waves: from 26 directions no pixel is open, at one level and at
 * mixed ones; depths and picks are those of the surface; roads draw the same bytes. Splats that
 * show the plane between samples are nearer to the truth than blended ones by 1 dB. Drawn in
 * reverse order, mesh and blended splats are the same. Where gaps between maps are filled, no pixel
 * is open either, and the cells and the triangles between are one closed mesh. */
#include "formats/chunk/codec/square/square.h"
#include "runtime/camera/camera.h"
#include "runtime/camera/orbit.h"
#include "runtime/gl/shader.h"
#include "runtime/renderer_parts.h"
#include "tests/fixtures/gl_model.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/support/views.h"

#include <stdlib.h>
#include <sys/stat.h>

/* The side of a cell, about: the root of the ball's surface by the points. */
#define CELL 0.0177

enum { SIZE = 160, PIXELS = SIZE * SIZE, POINTS = 40000, WAYS = 5, LENSES = 5, RIM_VIEWS = 6 };
#define MAPS_FILE "maps.stipple"
#define CHUNKS_FILE "chunks.stipple"
#define FILLED_FILE "filled.stipple" /* the same with the gaps between maps filled */
#define LENS_FILE "lens.stipple"
#define SHADER_FOLDER "maps-shaders"

static const stp_maps_as ways[WAYS] = {STP_MAPS_MESH, STP_MAPS_SPLATS, STP_MAPS_BLEND,
                                       STP_MAPS_PLAIN, STP_MAPS_POINTS};
static const char *const names[] = {"auto", "mesh", "splats", "blend", "plain", "points"};

/* ---- the surface ---- */

/* The height of a lens of radius 1 in place of the ball; 0: the ball. */
static double lens;

/* How far a place lies outside the surface: the gradient's length is nearly 1 there. */
static double outside(stp_dvec3 p)
{
    if (lens > 0.0) {
        const double k = sqrt(p.x * p.x + p.y * p.y + p.z * p.z / (lens * lens));
        return k * (k - 1.0) /
               sqrt(p.x * p.x + p.y * p.y + p.z * p.z / (lens * lens * lens * lens));
    }
    const double waves = sin(30.0 * p.x) * sin(30.0 * p.y + 1.0) * sin(30.0 * p.z + 2.0);
    return stp_dvec3_length(p) - 1.0 - 0.008 * waves;
}

static stp_dvec3 normal_at(stp_dvec3 p)
{
    const double h = 1e-5;
    return stp_dvec3_normalize((stp_dvec3){
        outside((stp_dvec3){p.x + h, p.y, p.z}) - outside((stp_dvec3){p.x - h, p.y, p.z}),
        outside((stp_dvec3){p.x, p.y + h, p.z}) - outside((stp_dvec3){p.x, p.y - h, p.z}),
        outside((stp_dvec3){p.x, p.y, p.z + h}) - outside((stp_dvec3){p.x, p.y, p.z - h})});
}

/* Where the ray of a pixel meets the surface first, in *out; false if it does not, or is not at
 * least `slack` deep inside somewhere. */
static bool cast(const stp_view *view, int pixel, double slack, stp_dvec3 *out)
{
    const double u = pixel % SIZE + 0.5, v = pixel / SIZE + 0.5;
    const stp_dvec3 way =
        stp_dvec3_normalize(stp_dvec3_sub(stp_view_unproject(view, u, v, 1.0), view->eye));
    double along = 0.0, deepest = 1.0, found = -1.0;
    for (int i = 0; i < 400; i++) {
        const double off = outside(stp_dvec3_add(view->eye, stp_dvec3_scale(way, along)));
        found = found < 0.0 && off < 1e-7 ? along : found;
        deepest = fmin(deepest, off);
        if (off > 3.0 && along > 3.0)
            break;
        along += fmax(found < 0.0 ? 0.8 * off : 0.005, 2e-8);
    }
    *out = stp_dvec3_add(view->eye, stp_dvec3_scale(way, found));
    return found >= 0.0 && deepest < -slack;
}

static stp_prep_stats prepare(const char *path, size_t points, bool fill)
{
    stp_prep_stats stats;
    const stp_maps_params maps = {.cone_deg = 60.0, .fill = fill};
    prep_cloud cloud = prep_cloud_make(points);
    for (size_t i = 0; i < cloud.count; i++) { /* along a spiral */
        const double z = 1.0 - 2.0 * ((double)i + 0.5) / (double)cloud.count;
        const double a = 2.39996322972865332 * (double)i, across = sqrt(1.0 - z * z);
        stp_dvec3 p = {across * cos(a), across * sin(a), lens > 0.0 ? z * lens : z};
        for (int k = 0; k < 20; k++)
            p = stp_dvec3_scale(p, 1.0 - outside(p));
        cloud.points[i].position = p;
    }
    check_ok(prep_cloud_run(
        &cloud, path, 2, &(stp_prep_params){.codec = STP_CODEC_DRACO, .maps = &maps}, &stats, err));
    free(cloud.points);
    return stats;
}

static void make_maps(void **state)
{
    (void)state;
    prepare(MAPS_FILE, POINTS, false);
    prepare(FILLED_FILE, POINTS, true);
}

static stp_view look(const gl_fixture *f, stp_dvec3 eye, double fovy_deg)
{
    stp_view view;
    const stp_camera camera = {
        .eye = eye, .look = {0.0, 0.0, 0.0}, .up = {0.0, 0.1, 1.0}, .fovy_deg = fovy_deg};
    check_ok(stp_view_create(&view, &camera, &f->model->ball, SIZE, SIZE, err));
    return view;
}

static const stp_dvec3 near_eye = {1.5, 0.9, 0.5};

static stp_draw_params params_for(stp_maps_as way)
{
    return (stp_draw_params){.shade = STP_SHADE_LAMBERT,
                             .colour = STP_COLOUR_NONE,
                             .every_sample = true,
                             .maps_as = way};
}

/* ---- coverage ---- */

/* Of the pixels whose ray goes well through the surface: how many there are, how many are open, and
 * how far the depth of one is off the surface at most. */
typedef struct judgement {
    size_t inside, open;
    double worst;
} judgement;

static void judge(const gl_fixture *f, const stp_view *view, const bool *inside, judgement *sum)
{
    static float depth[PIXELS];
    check_ok(stp_renderer_read_depth(f->renderer, depth, err));
    for (int i = 0; i < PIXELS; i++) {
        const stp_dvec3 at =
            stp_view_unproject(view, i % SIZE + 0.5, i / SIZE + 0.5, (double)depth[i]);
        sum->inside += inside[i];
        sum->open += inside[i] && !(depth[i] > 0.0f);
        sum->worst =
            inside[i] && depth[i] > 0.0f ? fmax(sum->worst, fabs(outside(at))) : sum->worst;
    }
}

static void no_pixel_is_open(void **state)
{
    (void)state;
    static uint8_t rgba[4 * PIXELS];
    static bool inside[PIXELS];
    judgement sums[2][WAYS] = {0};
    gl_fixture f = {0};
    gl_fixture_open(&f, MAPS_FILE, NULL);
    for (int i = 0; i < VIEWS_DIRECTIONS; i++) {
        const stp_view view = views_get(i, &f.model->ball, NULL, 0, SIZE, SIZE);
        stp_dvec3 hit;
        for (int k = 0; k < PIXELS; k++)
            inside[k] = cast(&view, k, 0.05, &hit);
        for (int mixed = 0; mixed < 2; mixed++)
            for (int k = 0; k < WAYS; k++) {
                stp_draw_params params = params_for(ways[k]);
                params.every_sample = mixed == 0;
                params.threshold_px = 0.2; /* some patches at level 0, others at level 1 */
                gl_fixture_draw(&f, &view, &params, NULL, rgba);
                judge(&f, &view, inside, &sums[mixed][k]);
            }
    }
    for (int mixed = 0; mixed < 2; mixed++)
        for (int k = 0; k < WAYS; k++) {
            const judgement *sum = &sums[mixed][k];
            print_message("%s, %s: %zu of %zu pixels open, the worst off by %g\n", names[ways[k]],
                          mixed ? "mixed levels" : "every sample", sum->open, sum->inside,
                          sum->worst);
            assert_true(sum->inside > VIEWS_DIRECTIONS * PIXELS / 10);
            assert_int_equal(sum->open, 0);
            assert_true(sum->worst < (mixed ? 0.1 : 0.05));
        }
    gl_fixture_close(&f);
}

/* Filled gaps, too; and there the mesh lies nearer to the surface than where maps overlap. */
static void no_pixel_between_filled_maps_is_open(void **state)
{
    (void)state;
    static uint8_t rgba[4 * PIXELS];
    static bool inside[PIXELS];
    judgement sums[2][2] = {0};
    gl_fixture files[2] = {0};
    gl_fixture_open(&files[0], MAPS_FILE, NULL);
    gl_fixture_open(&files[1], FILLED_FILE, NULL);
    for (int i = 0; i < VIEWS_DIRECTIONS; i++) {
        const stp_view view = views_get(i, &files[0].model->ball, NULL, 0, SIZE, SIZE);
        stp_dvec3 hit;
        for (int k = 0; k < PIXELS; k++)
            inside[k] = cast(&view, k, 0.05, &hit);
        for (int fill = 0; fill < 2; fill++)
            for (int mixed = 0; mixed <= fill; mixed++) {
                stp_draw_params params = params_for(STP_MAPS_MESH);
                params.every_sample = mixed == 0;
                params.threshold_px = 0.2;
                gl_fixture_draw(&files[fill], &view, &params, NULL, rgba);
                judge(&files[fill], &view, inside, &sums[fill][mixed]);
            }
    }
    for (int fill = 0; fill < 2; fill++)
        for (int mixed = 0; mixed <= fill; mixed++) {
            const judgement *sum = &sums[fill][mixed];
            print_message("%s, %s: %zu of %zu pixels open, the worst off by %g\n",
                          fill ? "filled" : "overlapping", mixed ? "mixed levels" : "every sample",
                          sum->open, sum->inside, sum->worst);
            assert_int_equal(sum->open, 0);
        }
    assert_true(sums[1][0].worst < sums[0][0].worst && sums[1][1].worst < 0.1);
    gl_fixture_close(&files[0]);
    gl_fixture_close(&files[1]);
}

/* What a pixel is in a picture of the surface, 0 to 255. */
static double grey_at(const stp_view *view, stp_dvec3 at)
{
    return 255.0 * 0.8 * (0.05 + 0.85 * fmax(0.0, stp_dvec3_dot(normal_at(at), view->back)));
}

/* sum: of squared errors of so many pixels, 0 to 255. */
static double psnr_of(double sum, size_t count)
{
    return 10.0 * log10(255.0 * 255.0 * (double)count / sum);
}

/* How near a pixel's ray comes to the surface; less than 0 inside. */
static double approach(const stp_view *view, int pixel)
{
    const stp_dvec3 way = stp_dvec3_normalize(stp_dvec3_sub(
        stp_view_unproject(view, pixel % SIZE + 0.5, pixel / SIZE + 0.5, 1.0), view->eye));
    double least = INFINITY;
    for (double along = 0.0; along < 6.0;) {
        const double off = outside(stp_dvec3_add(view->eye, stp_dvec3_scale(way, along)));
        least = fmin(least, off);
        along += fmax(0.5 * fabs(off), 0.001);
    }
    return least;
}

/* Judges the rim of a lens from near: *db, against the truth; *beyond: pixels beyond the outline.
 */
static void judge_rim(double thickness, double *db, double *beyond)
{
    static uint8_t rgba[4 * PIXELS];
    const stp_draw_params params = params_for(STP_MAPS_MESH);
    size_t hits = 0, far = 0;
    double sum = 0.0;
    gl_fixture f = {0};
    lens = thickness;
    prepare(LENS_FILE, POINTS, false);
    gl_fixture_open(&f, LENS_FILE, NULL);
    for (int i = 0; i < RIM_VIEWS; i++) {
        const double a = 2.0 * M_PI / RIM_VIEWS * i;
        const stp_camera camera = {.eye = {3.0 * cos(a), 3.0 * sin(a), 1.0},
                                   .look = {-sin(a), cos(a), 0.0},
                                   .up = {0.0, 0.0, 1.0},
                                   .fovy_deg = 8.0};
        stp_view view;
        check_ok(stp_view_create(&view, &camera, &f.model->ball, SIZE, SIZE, err));
        gl_fixture_draw(&f, &view, &params, NULL, rgba);
        for (int k = 0; k < PIXELS; k++) {
            stp_dvec3 hit;
            const double off = rgba[4 * k + 3] ? approach(&view, k) : -INFINITY;
            if (rgba[4 * k + 3] && cast(&view, k, 0.01, &hit)) {
                const double error = rgba[4 * k] - grey_at(&view, hit);
                sum += error * error;
                hits++;
            }
            far += off > CELL / 3.0;
        }
    }
    *db = psnr_of(sum, hits);
    *beyond = (double)far;
    gl_fixture_close(&f);
    lens = 0.0;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* From near, borders of maps do not stick out over the sharp rim of a lens, where they are steep.
 * The median of several lenses, for a rounding may decide where maps are cut. */
static void borders_do_not_stick_out(void **state)
{
    (void)state;
    double db[LENSES], beyond[LENSES];
    for (int i = 0; i < LENSES; i++) {
        judge_rim(0.12 + 0.02 * i, &db[i], &beyond[i]);
        print_message("rim: %.1f dB, %.0f pixels beyond the outline\n", db[i], beyond[i]);
    }
    qsort(db, LENSES, sizeof *db, by_size);
    qsort(beyond, LENSES, sizeof *beyond, by_size);
    assert_true(db[LENSES / 2] >= 51.5);
    assert_true(beyond[LENSES / 2] <= 40.0 * RIM_VIEWS / 12);
}

/* Whether a square has a sample at a column and row, both 0 to 8: then it is in a square beside. */
static bool square_has(const stp_squares *s, size_t square, int column, int row)
{
    static const int which[2][2] = {{-1, 4}, {6, 7}}; /* by rows, then by columns */
    const int side = which[row >> 3][column >> 3];
    const uint32_t at = side < 0 ? (uint32_t)square : s->records[square].beside[side];
    const uint32_t place = stp_square_morton((uint32_t)column & 7u, (uint32_t)row & 7u);
    return at != UINT32_MAX && (s->records[at].samples[place >> 5] >> (place & 31u) & 1u) != 0;
}

/* All cells between four samples are drawn as such, also where the samples are in several chunks.
 * The mesh is closed, so Euler's formula tells how many there are: triangles = 2 vertices - 4. */
static void cells_go_on_in_other_chunks(void **state)
{
    (void)state;
    static uint8_t rgba[4 * PIXELS];
    gl_fixture f = {0};
    size_t cells = 0;
    const stp_prep_stats stats = prepare(CHUNKS_FILE, 2 * 65536, true);
    gl_fixture_open(&f, CHUNKS_FILE, NULL);
    const stp_view view = views_get(0, &f.model->ball, NULL, 0, SIZE, SIZE);
    const stp_draw_params params = params_for(STP_MAPS_MESH);
    gl_fixture_draw(&f, &view, &params, NULL, rgba);
    const stp_squares *s = &f.renderer->project.squares;
    for (size_t i = 0; i < s->triangles; i++)
        for (int k = 0; k < 64; k++) {
            const int c = k % 8, r = k / 8;
            cells += square_has(s, i, c, r) && square_has(s, i, c + 1, r) &&
                     square_has(s, i, c, r + 1) && square_has(s, i, c + 1, r + 1);
        }
    print_message("%zu cells in %u chunks\n", cells, stats.tree.chunk_count);
    assert_true(stats.maps.samples > 65536 && stats.maps.as_points == 0); /* several leaves */
    assert_int_equal(2 * cells + stats.maps.between, 2 * stats.maps.samples - 4);
    gl_fixture_close(&f);
}

static void roads_draw_the_same(void **state)
{
    (void)state;
    static const stp_lod roads[] = {STP_LOD_COMPUTE, STP_LOD_GEOMETRY, STP_LOD_CPU, STP_LOD_FULL};
    static uint8_t first[4 * PIXELS], rgba[4 * PIXELS];
    gl_fixture f = {0};
    gl_fixture_open(&f, MAPS_FILE, NULL);
    const stp_view view = look(&f, near_eye, 40.0);
    for (stp_maps_as way = STP_MAPS_SPLATS; way <= STP_MAPS_PLAIN; way++)
        for (size_t k = 0; k < sizeof roads / sizeof *roads; k++) {
            stp_draw_params params = params_for(way);
            params.lod = roads[k];
            gl_fixture_draw(&f, &view, &params, NULL, k ? rgba : first);
            if (k > 0)
                assert_memory_equal(rgba, first, sizeof first);
        }
    gl_fixture_close(&f);
}

/* Where no patch is drawn at level 0, maps are drawn as points are, whatever is wanted. */
static void coarse_samples_are_points(void **state)
{
    (void)state;
    static uint8_t first[4 * PIXELS], rgba[4 * PIXELS];
    gl_fixture f = {0};
    gl_fixture_open(&f, MAPS_FILE, NULL);
    const stp_view view = views_get(0, &f.model->ball, NULL, 0, SIZE, SIZE);
    for (int k = WAYS - 1; k >= 0; k--) { /* the last are points */
        stp_draw_params params = params_for(ways[k]);
        params.every_sample = false;
        params.threshold_px = 2.0;
        params.terms = STP_TERM_NONE;
        gl_fixture_draw(&f, &view, &params, NULL, k < WAYS - 1 ? rgba : first);
        if (k < WAYS - 1)
            assert_memory_equal(rgba, first, sizeof first);
    }
    gl_fixture_close(&f);
}

/* ---- quality ---- */

/* Decibels between a picture and the true surface, where that is seen at less than 70 degrees. */
static double psnr_db(const stp_view *view, const uint8_t *rgba)
{
    double sum = 0.0;
    size_t count = 0;
    for (int i = 0; i < PIXELS; i++) {
        stp_dvec3 hit;
        if (!cast(view, i, 0.01, &hit))
            continue;
        const stp_dvec3 n = normal_at(hit),
                        way = stp_dvec3_normalize(stp_dvec3_sub(view->eye, hit));
        if (stp_dvec3_dot(n, way) < cos(70.0 * M_PI / 180.0))
            continue;
        const double grey = grey_at(view, hit);
        sum += (rgba[4 * i] - grey) * (rgba[4 * i] - grey);
        count++;
    }
    assert_true(count > PIXELS / 2);
    return psnr_of(sum, count);
}

static void splats_are_nearer_to_the_truth(void **state)
{
    (void)state;
    static uint8_t rgba[4 * PIXELS];
    gl_fixture f = {0};
    double db[STP_MAPS_POINTS + 1];
    gl_fixture_open(&f, MAPS_FILE, NULL);
    const stp_view view = look(&f, near_eye, 12.0);
    for (int k = 0; k < WAYS; k++) {
        const stp_draw_params params = params_for(ways[k]);
        gl_fixture_draw(&f, &view, &params, NULL, rgba);
        db[ways[k]] = psnr_db(&view, rgba);
        print_message("%s: %.1f dB\n", names[ways[k]], db[ways[k]]);
    }
    assert_true(db[STP_MAPS_SPLATS] >= db[STP_MAPS_BLEND] + 1.0);
    assert_true(db[STP_MAPS_BLEND] >= db[STP_MAPS_PLAIN] + 1.0);
    gl_fixture_close(&f);
}

/* ---- order ---- */

/* Writes a shader with one text in place of another. */
static void write_changed(const char *name, const char *before, const char *after)
{
    char path[128];
    const char *text = "";
    for (const stp_shader_file *file = stp_shader_files; file->name; file++)
        text = strcmp(file->name, name) == 0 ? file->text : text;
    const char *at = strstr(text, before);
    assert_non_null(at);
    snprintf(path, sizeof path, SHADER_FOLDER "/%s", name);
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    assert_true(fprintf(out, "%.*s%s%s", (int)(at - text), text, after, at + strlen(before)) > 0);
    assert_int_equal(fclose(out), 0);
}

/* Draws the last square first, and of equal depths takes the other. */
static void order_changes_nothing(void **state)
{
    (void)state;
    static uint8_t forth[4 * PIXELS], back[4 * PIXELS];
    gl_fixture f = {0}, reversed = {0};
    (void)mkdir(SHADER_FOLDER, 0777);
    write_changed(
        "map_list.comp", "squares.x + gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;",
        "squares.x + gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;\n"
        "    listed = listed < squares.y ? squares.y - 1u - (listed - squares.x) : squares.y;");
    write_changed("map_front.frag", "s.splat < p.front", "s.splat > p.front");
    write_changed("square.comp", "draws[square] =", "draws[squares.y - 1u - square] =");
    write_changed(
        "square_quarters.comp", "draws[square].count, 6u) + draws[square].first",
        "draws[squares.y - 1u - square].count, 6u) + draws[squares.y - 1u - square].first");
    gl_fixture_open(&f, MAPS_FILE, NULL);
    gl_fixture_open(&reversed, MAPS_FILE, SHADER_FOLDER);
    const stp_view view = look(&f, near_eye, 40.0);
    for (stp_maps_as way = STP_MAPS_MESH; way <= STP_MAPS_PLAIN; way++) {
        const stp_draw_params params = params_for(way);
        size_t differ = 0, beyond = 0;
        gl_fixture_draw(&f, &view, &params, NULL, forth);
        gl_fixture_draw(&reversed, &view, &params, NULL, back);
        for (int i = 0; i < 4 * PIXELS; i++) {
            differ += forth[i] != back[i];
            beyond += abs(forth[i] - back[i]) > 2;
        }
        print_message("%s: %zu values differ, %zu by more than 2\n", names[way], differ, beyond);
        /* a plain pixel has the colour of one splat, also where two are equally near */
        assert_true(beyond <= (way == STP_MAPS_PLAIN ? 12 : 0));
    }
    gl_fixture_close(&f);
    gl_fixture_close(&reversed);
}

/* ---- picks, and what is drawn as what ---- */

static void picks_find_the_surface(void **state)
{
    (void)state;
    static uint8_t rgba[4 * PIXELS];
    gl_fixture f = {0};
    gl_fixture_open(&f, MAPS_FILE, NULL);
    const stp_view view = look(&f, near_eye, 20.0);
    for (stp_maps_as way = STP_MAPS_SPLATS; way <= STP_MAPS_PLAIN; way++) {
        const stp_draw_params params = params_for(way);
        gl_fixture_draw(&f, &view, &params, NULL, rgba);
        size_t found = 0, farthest = 0;
        for (int k = 0; k < 100; k++) {
            stp_pick pick;
            stp_dvec3 hit;
            const int x = (int)(SIZE * stp_random_unit(1, (uint64_t)k));
            const int y = (int)(SIZE * stp_random_unit(2, (uint64_t)k));
            check_ok(stp_renderer_pick(f.renderer, x, y, &pick, err));
            assert_true(pick.hit && pick.level == 0);
            assert_int_not_equal(pick.chunk, STP_PICK_NO_CHUNK);
            if (!cast(&view, y * SIZE + x, 0.05, &hit))
                continue;
            found++;
            farthest += stp_dvec3_length(stp_dvec3_sub(pick.position, hit)) > 0.01;
        }
        print_message("%s: %zu picks, %zu far from the surface\n", names[way], found, farthest);
        assert_true(found > 50 && farthest == 0);
    }
    gl_fixture_close(&f);
}

/* How many pixels are drawn as cells or splats of maps, and as points. */
static void count_primitives(const gl_fixture *f, const stp_view *view, stp_maps_as way,
                             size_t out[2])
{
    static uint8_t rgba[4 * PIXELS];
    const stp_draw_params params = {
        .shade = STP_SHADE_PRIMITIVE, .maps_as = way, .grid_draw = STP_GRID_POINTS};
    gl_fixture_draw(f, view, &params, NULL, rgba);
    out[0] = out[1] = 0;
    for (int i = 0; i < PIXELS; i++) {
        out[0] += rgba[4 * i + 3] && rgba[4 * i] > rgba[4 * i + 2];
        out[1] += rgba[4 * i + 3] && rgba[4 * i] < rgba[4 * i + 2];
    }
}

static void each_way_is_drawn_where_it_is_wanted(void **state)
{
    (void)state;
    gl_fixture f = {0};
    gl_fixture_open(&f, MAPS_FILE, NULL);
    const stp_view close = look(&f, near_eye, 4.0);
    const stp_view distant = views_get(0, &f.model->ball, NULL, 0, SIZE, SIZE);
    for (stp_maps_as way = STP_MAPS_AUTO; way <= STP_MAPS_POINTS; way++) {
        size_t by_close[2], by_distant[2];
        count_primitives(&f, &close, way, by_close);
        count_primitives(&f, &distant, way, by_distant);
        print_message("%s: close %zu and %zu points, distant %zu and %zu\n", names[way],
                      by_close[0], by_close[1], by_distant[0], by_distant[1]);
        assert_int_equal(by_close[way == STP_MAPS_POINTS], PIXELS);
        assert_true(way == STP_MAPS_AUTO || way == STP_MAPS_POINTS ? by_distant[0] == 0
                                                                   : by_distant[0] > 0);
    }
    gl_fixture_close(&f);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(make_maps),
        cmocka_unit_test(no_pixel_is_open),
        cmocka_unit_test(no_pixel_between_filled_maps_is_open),
        cmocka_unit_test(borders_do_not_stick_out),
        cmocka_unit_test(cells_go_on_in_other_chunks),
        cmocka_unit_test(roads_draw_the_same),
        cmocka_unit_test(coarse_samples_are_points),
        cmocka_unit_test(splats_are_nearer_to_the_truth),
        cmocka_unit_test(order_changes_nothing),
        cmocka_unit_test(picks_find_the_surface),
        cmocka_unit_test(each_way_is_drawn_where_it_is_wanted),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stp_gl_context_destroy(&context);
    return failed;
}
