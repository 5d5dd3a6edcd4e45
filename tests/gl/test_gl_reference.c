/* Tests the GPU's reconstruction against the CPU reference, pixel by pixel: nine scenes, odd
 * viewports, both kinds of filter. Normals and colours must agree within 1e-3, depths within 1e-3
 * of the disc's radius and 1e-6 of the depth, and both must name the same pyramid level as the
 * source, on at least 99.9 % of the pixels that either covers.
 *
 * A software rasteriser needs minutes for all of it. The three templates are one shader with
 * windows of three widths, and gauss and box are one shader with two kinds of weights: the test
 * judges each scene with one of either, in turns. It judges each
 * mode from five of the ten views: even views in one scene, odd views in the next. Of these, scenes
 * without lines leave out one of the two large pictures. With the argument --every, as in
 * long_gl_reference, it judges each scene in all modes from all views, and in larger pictures, as
 * scenes with lines always are.
 *
 * The GPU decides with floats which of two samples is nearer, or in which pixel a sample lies. In
 * doubles, two samples may differ by only a float's last bits. Such a pixel of level 0 is a tie: if
 * the GPU's choice is justified, the reference follows it, and the pixel is counted as settled. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/hole_fixture.h"
#include "tests/fixtures/line_fixture.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/support/reference_parts.h"
#include "tests/support/views.h"

#define TOLERANCE 1e-3
#define SHARE_WANTED 0.999
/* The share of ties in scenes with lines: drivers may differ at the ends of segments. */
#define SHAPE_TIES 0.005

/* How far a float may be off: relative for a depth, and in pixels. All depths of a patch may be off
 * alike, by the rounding of its place before the eye. */
#define TIE_DEPTH 1e-6
#define TIE_PX 1e-3

typedef struct agreement {
    size_t settled; /* ties */
    size_t shaded;  /* pixels of the picture that differ */
    size_t either, agree, coverage, normal, colour, depth, source;
} agreement;

/* The unit for a pixel's depth and radius: the disc's radius. For polygons, whose radius is next to
 * none, and for flat pieces of ribbons, which have no radius, it is the range of depths. */
static double size_of(const reference_pixel *p)
{
    return reference_is_polygon(p) || p->radius == 0.0 ? p->z_max - p->z_min : p->radius;
}

static void compare_pixel(const reference_pixel *a, const reference_pixel *b, agreement *sum)
{
    if (a->tag == 0 && b->tag == 0)
        return;
    sum->either++;
    if (a->tag == 0 || b->tag == 0) {
        sum->coverage++;
        return;
    }
    bool normal = stp_dvec3_length(stp_dvec3_sub(a->normal, b->normal)) <= TOLERANCE;
    bool depth = fabs(a->z_min - b->z_min) <= TOLERANCE * size_of(b) + TIE_DEPTH * b->z_min;
    bool colour = true;
    for (int k = 0; k < 3; k++)
        colour &= fabs(a->rgb[k] - b->rgb[k]) <= TOLERANCE;
    bool source = (a->tag - 1) >> 4 == (b->tag - 1) >> 4;
    sum->source += !source;
    sum->normal += !normal;
    sum->depth += !depth;
    sum->colour += !colour;
    sum->agree += normal && depth && colour && source;
}

/* Shaded pictures have 8 bits: allows one step of rounding and the tolerance. */
static size_t compare_pictures(const gl_fixture *f, const reference_pyramid *reference,
                               stp_shade shade)
{
    size_t count = (size_t)reference->view.width * (size_t)reference->view.height, wrong = 0;
    uint8_t *picture = calloc(count, 4);
    double *expected = calloc(count, 4 * sizeof *expected);
    assert_true(picture != NULL && expected != NULL);
    check_ok(stp_renderer_read(f->renderer, picture, err));
    reference_shade_picture(reference, (reference_shade)shade, expected);
    for (size_t i = 0; i < count; i++) {
        bool good = true;
        for (size_t k = 0; k < 4; k++)
            good &= fabs(picture[4 * i + k] - 255.0 * expected[4 * i + k]) <=
                    0.5 + 255.0 * 3.0 * TOLERANCE;
        wrong += !good;
    }
    free(picture);
    free(expected);
    return wrong;
}

/* ---- ties ---- */

/* The disc that each pixel of level 0 shows. */
typedef struct winners {
    const stp_view *view;
    const reference_disc *discs;
    double *sure_depth; /* of the nearest disc that no rounding can move to another pixel */
    size_t *disc;       /* index + 1 of the nearest disc, 0: none */
} winners;

/* Finds the disc's window coordinates; returns false if the disc is not drawn. */
static bool place(const stp_view *view, const reference_disc *disc, double window[2])
{
    double depth = -disc->position.z, scale = view->orthographic ? view->f : view->f / depth;
    stp_dvec3 w = view->orthographic ? (stp_dvec3){0.0, 0.0, -1.0} : disc->position;
    window[0] = 0.5 * view->width + scale * disc->position.x;
    window[1] = 0.5 * view->height + scale * disc->position.y;
    return depth > view->near_depth &&
           !(disc->culled && !disc->seen_through &&
             stp_dvec3_dot(disc->normal, stp_dvec3_normalize(w)) >= REFERENCE_CULL_COSINE);
}

/* The index of the pixel at window coordinates, or -1. */
static int pixel_index(const stp_view *view, double u, double v)
{
    bool inside = u >= 0.0 && v >= 0.0 && u < view->width && v < view->height;
    return inside ? (int)v * view->width + (int)u : -1;
}

static void find_winners(winners *win, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        double p[2];
        if (!place(win->view, &win->discs[i], p))
            continue;
        int at = pixel_index(win->view, p[0], p[1]);
        double depth = -win->discs[i].position.z;
        reference_presence presence = win->discs[i].presence;
        if (at < 0)
            continue;
        if (presence != REFERENCE_MISSING &&
            (win->disc[at] == 0 || depth < -win->discs[win->disc[at] - 1].position.z))
            win->disc[at] = i + 1;
        bool sure = presence == REFERENCE_SURE;
        for (int k = 0; k < 4; k++)
            sure &= pixel_index(win->view, p[0] + (k & 1 ? TIE_PX : -TIE_PX),
                                p[1] + (k & 2 ? TIE_PX : -TIE_PX)) == at;
        if (sure)
            win->sure_depth[at] = fmin(win->sure_depth[at], depth);
    }
}

/* Whether the GPU's pixel at an index shows this disc. */
static bool shows(const stp_view *view, const reference_pixel *gpu, int at,
                  const reference_disc *disc)
{
    double p[2];
    const reference_pixel *pixel = &gpu[at];
    return place(view, disc, p) && fabs(p[0] - (at % view->width + 0.5 + pixel->dx)) <= TIE_PX &&
           fabs(p[1] - (at / view->width + 0.5 + pixel->dy)) <= TIE_PX &&
           fabs(-disc->position.z - pixel->z_min) <= TIE_DEPTH * pixel->z_min;
}

/* If the GPU shows another disc that may be there, or no disc where none needs to be, follows the
 * GPU. Returns the number of such pixels. */
static size_t settle(winners *win, size_t count, const reference_pixel *gpu)
{
    size_t settled = 0;
    for (int at = 0; at < win->view->width * win->view->height; at++)
        if (win->disc[at] != 0 && gpu[at].tag == 0 && isinf(win->sure_depth[at])) {
            win->disc[at] = 0;
            settled++;
        }
    for (size_t i = 0; i < count; i++) {
        double p[2];
        if (!place(win->view, &win->discs[i], p))
            continue;
        for (int k = 0; k < 5; k++) {
            int at = pixel_index(win->view, p[0] + (k & 1 ? TIE_PX : -TIE_PX) * (k < 4),
                                 p[1] + (k & 2 ? TIE_PX : -TIE_PX) * (k < 4));
            if (at < 0 || gpu[at].tag == 0 || win->disc[at] == i + 1 ||
                !shows(win->view, gpu, at, &win->discs[i]) ||
                -win->discs[i].position.z > win->sure_depth[at] * (1.0 + TIE_DEPTH) ||
                (win->disc[at] != 0 && shows(win->view, gpu, at, &win->discs[win->disc[at] - 1])))
                continue;
            win->disc[at] = i + 1;
            settled++;
        }
    }
    return settled;
}

/* Projects each winner into its pixel. */
static void project_winners(reference_pyramid *reference, const winners *win)
{
    const stp_view *view = win->view;
    for (int at = 0; at < view->width * view->height; at++) {
        if (win->disc[at] == 0)
            continue;
        reference_disc disc = win->discs[win->disc[at] - 1];
        double p[2];
        assert_true(place(view, &disc, p));
        double scale = view->orthographic ? view->f : view->f / -disc.position.z;
        double x = at % view->width, y = at / view->width;
        disc.position.x += (fmin(fmax(p[0], x + 1e-9), x + 1.0 - 1e-9) - p[0]) / scale;
        disc.position.y += (fmin(fmax(p[1], y + 1e-9), y + 1.0 - 1e-9) - p[1]) / scale;
        reference_project(reference, &disc, 1);
    }
}

/* Takes the GPU's own floats of level 0 if they are right except for a float's last bits. These
 * floats decide whether two intervals meet, and one such decision affects a whole window. */
static void adopt_floats(reference_pyramid *reference, const reference_pixel *gpu)
{
    for (int at = 0; at < reference->view.width * reference->view.height; at++) {
        reference_pixel *p = &reference->levels[0].pulled[at];
        const reference_pixel *g = &gpu[at];
        if (p->tag != g->tag || fabs(p->z_min - g->z_min) > TIE_DEPTH * p->z_min ||
            fabs(p->z_max - g->z_max) > TOLERANCE * (p->z_max - p->z_min) ||
            fabs(p->radius - g->radius) > TIE_DEPTH * size_of(p))
            continue;
        p->z_min = g->z_min;
        p->z_max = g->z_max;
        p->radius = g->radius;
        p->dx = fabs(p->dx - g->dx) <= TIE_PX ? g->dx : p->dx;
        p->dy = fabs(p->dy - g->dy) <= TIE_PX ? g->dy : p->dy;
    }
}

static size_t project_settled(reference_pyramid *reference, const reference_disc *discs,
                              size_t count, const reference_pixel *gpu)
{
    size_t pixels = (size_t)reference->view.width * (size_t)reference->view.height;
    winners win = {&reference->view, discs, calloc(pixels, sizeof *win.sure_depth),
                   calloc(pixels, sizeof *win.disc)};
    if (win.sure_depth == NULL || win.disc == NULL)
        fail_msg("no memory");
    for (size_t i = 0; i < pixels; i++)
        win.sure_depth[i] = INFINITY;
    find_winners(&win, count);
    size_t settled = settle(&win, count, gpu);
    project_winners(reference, &win);
    adopt_floats(reference, gpu);
    free(win.sure_depth);
    free(win.disc);
    return settled;
}

/* ---- scenes ---- */

static const int sizes_every[][2] = {{512, 512}, {257, 129}, {333, 480}, {3, 7}, {1, 1}};
static const int sizes_usual[][2] = {{384, 384}, {257, 129}, {250, 360}, {3, 7}, {1, 1}};

/* Draws the model with both and adds up how they agree. */
static agreement judge_view(gl_fixture *f, const stp_view *view, stp_reconstruct reconstruct,
                            stp_shade shade, double threshold_px)
{
    agreement sum = {0};
    static const reference_filter filters[] = {
        [STP_RECONSTRUCT_GAUSS] = REFERENCE_GAUSS,
        [STP_RECONSTRUCT_BOX] = REFERENCE_BOX,
        [STP_RECONSTRUCT_TEMPLATE3] = REFERENCE_TEMPLATE3,
        [STP_RECONSTRUCT_TEMPLATE5] = REFERENCE_TEMPLATE5,
        [STP_RECONSTRUCT_TEMPLATE7] = REFERENCE_TEMPLATE7,
        [STP_RECONSTRUCT_SPLAT] = REFERENCE_SPLAT,
    };
    stp_draw_stats stats;
    reference_pyramid reference;
    bool large = view->width == sizes_every[0][0] || view->width == sizes_usual[0][0];
    stp_draw_params params = {.lod = large ? STP_LOD_GEOMETRY : STP_LOD_COMPUTE,
                              .reconstruct = reconstruct,
                              .shade = shade,
                              .threshold_px = threshold_px,
                              .every_sample = threshold_px == 0.0,
                              .cull = shade == STP_SHADE_LAMBERT ? STP_CULL_NONE : STP_CULL_AUTO,
                              .keep_pixels = true};
    check_ok(stp_renderer_draw(f->renderer, view, &params, &stats, err));
    assert_true(stats.cut_complete);
    reference_disc_list discs = gl_fixture_discs(f, view, reconstruct == STP_RECONSTRUCT_SPLAT);
    check_ok(reference_create(&reference, view, filters[reconstruct], stats.pyramid_levels, err));
    reference.grid = f->model->is_grid;
    bool finishes = reconstruct >= STP_RECONSTRUCT_TEMPLATE3 || stats.pyramid_levels > 0;
    reference_pixel *pulled = gl_fixture_pixels(f, false);
    reference_pixel *pixels = gl_fixture_pixels(f, finishes);
    if (reconstruct == STP_RECONSTRUCT_SPLAT) {
        check_ok(reference_splat(&reference, discs.items, discs.count, err));
    } else {
        sum.settled = project_settled(&reference, discs.items, discs.count, pulled);
        reference_pull(&reference);
        reference_push(&reference);
    }
    for (int i = 0; i < view->width * view->height; i++)
        compare_pixel(&pixels[i], &reference.levels[0].finished[i], &sum);
    sum.shaded = compare_pictures(f, &reference, shade);
    free(pulled);
    free(pixels);
    reference_disc_list_clear(&discs);
    reference_destroy(&reference);
    return sum;
}

enum { PUSH_COUNT = 2, FIRST_TEMPLATE = PUSH_COUNT, TEMPLATE_COUNT = 3, MODE_COUNT = 6 };
static const struct {
    const char *name;
    stp_reconstruct reconstruct;
} modes[MODE_COUNT] = {
    {"gauss", STP_RECONSTRUCT_GAUSS},         {"box", STP_RECONSTRUCT_BOX},
    {"template3", STP_RECONSTRUCT_TEMPLATE3}, {"template5", STP_RECONSTRUCT_TEMPLATE5},
    {"template7", STP_RECONSTRUCT_TEMPLATE7}, {"splat", STP_RECONSTRUCT_SPLAT},
};

static bool everything; /* in every scene, from every view */

/* Is this mode left to other scenes? scene: counts the scenes. Each mode has scenes of even and of
 * odd numbers, so that is_left_to_next leaves it all views. */
static bool is_left_out(size_t mode, int scene)
{
    if (everything || mode >= FIRST_TEMPLATE + TEMPLATE_COUNT)
        return false;
    size_t push = scene == 2 || scene == 3 || scene == 7; /* box; gauss in other scenes */
    return mode < PUSH_COUNT ? mode != push
                             : mode - FIRST_TEMPLATE != (size_t)scene % TEMPLATE_COUNT;
}

/* Is this view left to another scene? Five views have each size once. shapes: the scene has lines,
 * which agree less in small pictures; other scenes leave out one of the two large pictures. */
static bool is_left_to_next(size_t mode, int view, int scene, bool shapes)
{
    int turn = (int)mode + scene;
    bool large = !shapes && view % 5 == (turn / 2 % 2 == 0 ? 0 : 2);
    return !everything && ((turn + view) % 2 != 0 || large);
}

/* Judges views of one model: around it, close to it with 100 degrees, and orthographic. ties: the
 * share of the pixels that may be settled. */
static void judge_model(const char *name, double ties)
{
    static int scene = -1;
    const int(*sizes)[2] = everything || ties == SHAPE_TIES ? sizes_every : sizes_usual;
    gl_fixture f = {0};
    promise_disc *leaves = NULL;
    size_t leaf_count = 0;
    gl_fixture_open(&f, "scene.stipple", NULL);
    check_ok(promise_load_leaves(f.model->file, &leaves, &leaf_count, err));
    scene++;
    for (size_t m = 0; m < MODE_COUNT; m++) {
        if (is_left_out(m, scene))
            continue;
        agreement total = {0};
        size_t judged = 0;
        for (int i = 0; i < 10; i++) {
            const int *size = sizes[i % 5];
            if (is_left_to_next(m, i, scene, ties == SHAPE_TIES))
                continue;
            judged++;
            stp_view view = views_get(i < 8   ? 5 * i
                                      : i < 9 ? 27
                                              : 31,
                                      &f.model->ball, leaves, leaf_count, size[0], size[1]);
            if (i == 3 || i == 7) {
                view.orthographic = true;
                view.f = 0.45 * size[1] / f.model->ball.radius;
            }
            agreement a = judge_view(&f, &view, modes[m].reconstruct, (stp_shade)(i % 4),
                                     i % 3 ? (double)(i % 3) : 0.0);
            if ((double)a.agree < SHARE_WANTED * (double)a.either - 1.0)
                print_message("%s %s view %d: %zu of %zu agree; coverage %zu, normal %zu, colour "
                              "%zu, depth %zu, source %zu differ\n",
                              name, modes[m].name, i, a.agree, a.either, a.coverage, a.normal,
                              a.colour, a.depth, a.source);
            total.either += a.either;
            total.agree += a.agree;
            total.coverage += a.coverage;
            total.settled += a.settled;
            total.shaded += a.shaded;
        }
        print_message("%s %s: %zu of %zu pixels agree, %.4f %%, coverage of %zu differs, %zu ties, "
                      "%zu shaded differ\n",
                      name, modes[m].name, total.agree, total.either,
                      100.0 * (double)total.agree / (double)total.either, total.coverage,
                      total.settled, total.shaded);
        assert_true(judged >= (everything ? 10 : 4) && total.either > 4000 * judged);
        assert_true((double)total.settled <= ties * (double)total.either);
        assert_true((double)total.shaded <= (1.0 - SHARE_WANTED) * (double)total.either);
        assert_true((double)total.agree >= SHARE_WANTED * (double)total.either);
    }
    free(leaves);
    gl_fixture_close(&f);
}

static void judge_scene(const char *name, const model_recipe *recipe)
{
    model_fixture_build("scene.stipple", recipe);
    judge_model(name, 1.0 - SHARE_WANTED);
}

#define SCENE(name, ...)                                                                           \
    static void name(void **state)                                                                 \
    {                                                                                              \
        (void)state;                                                                               \
        judge_scene(#name, &(model_recipe){__VA_ARGS__});                                          \
    }

SCENE(bumpy, .shape = GEN_BUMPY, .point_count = 60000, .noise_spacings = 0.1)
SCENE(statue, .shape = GEN_STATUE, .point_count = 60000)
SCENE(torus, .shape = GEN_TORUS, .point_count = 40000, .true_normals = true)
SCENE(terrain, .shape = GEN_TERRAIN, .point_count = 30000)
SCENE(sheet, .shape = GEN_SHEET, .point_count = 20000, .true_normals = true)
SCENE(two_sided, .shape = GEN_STATUE, .point_count = 30000, .orient = STP_ORIENT_NONE)

/* Alternates ribbons and tubes; tubes face the eye and keep their tangents. */
static stp_line_set ribbons_and_tubes(uint64_t strips, uint64_t each)
{
    stp_line_set out =
        line_set_helices(strips, each, (stp_dvec3){0.0, 0.0, 0.0}, 1.0, 0.05, STP_LINE_TUBE);
    for (uint64_t i = 0; i < out.strip_count; i += 2) {
        out.strips[i].kind = STP_LINE_RIBBON;
        for (uint64_t k = 0; k < out.strips[i].count; k++)
            out.vertices[out.strips[i].begin + k].direction = (vec3s){{0.6f, 0.0f, 0.8f}};
    }
    return out;
}

static void lines(void **state)
{
    (void)state;
    stp_line_set set = ribbons_and_tubes(60, 300);
    stp_prep_stats stats;
    check_ok(line_set_run(&set, NULL, "scene.stipple", 2, NULL, &stats, err));
    stp_line_set_clear(&set);
    judge_model("lines", SHAPE_TIES);
}

/* Triangles with a border next to points, and lines and points inside one another. */
static void mixed(void **state)
{
    (void)state;
    stp_line_set lines = ribbons_and_tubes(20, 300);
    stp_triangle_set grid = triangle_set_grid(24, (stp_dvec3){-1.0, -4.0, 2.01});
    prep_cloud points = prep_cloud_wavy(20000, (stp_dvec3){2.0, 0.0, 2.0}, 2.5);
    stp_prep_stats stats;
    for (uint64_t i = 0; i <= 24; i++)
        grid.vertices[i].radius = 0.1f;
    check_ok(prep_shapes_run(&points, &lines, &grid, "scene.stipple", 2, NULL, &stats, err));
    free(points.points);
    stp_triangle_set_clear(&grid);
    stp_line_set_clear(&lines);
    judge_model("mixed", SHAPE_TIES);
}

static void grid(void **state)
{
    (void)state;
    stp_prep_stats stats;
    prep_cloud points = hole_cloud(hole_discs);
    check_ok(prep_cloud_run(&points, "scene.stipple", 2, NULL, &stats, err));
    free(points.points);
    judge_model("grid", 1.0 - SHARE_WANTED);
}

int main(int argc, char **argv)
{
    everything = argc > 1 && strcmp(argv[1], "--every") == 0;
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bumpy),   cmocka_unit_test(statue), cmocka_unit_test(torus),
        cmocka_unit_test(terrain), cmocka_unit_test(sheet),  cmocka_unit_test(two_sided),
        cmocka_unit_test(lines),   cmocka_unit_test(mixed),  cmocka_unit_test(grid),
    };
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}
