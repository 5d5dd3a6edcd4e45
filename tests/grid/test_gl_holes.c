/* Tests what grids of heights promise of their holes, from both sides: no valid sample lies farther
 * than the threshold from what is drawn, and nothing is drawn farther than the threshold from a
 * valid sample, so wider holes stay open. The truth are the triangles between valid samples, drawn
 * on the CPU with the same camera. Where holes grow, nothing may be drawn but where samples are,
 * whatever the threshold, and single missing samples are holes, too.
 *
 * Masks: a twentieth of the samples scattered; stripes; discs of 1 to 1000 samples, also over the
 * borders of patches, blocks and leaves. The whole grid from 26 directions, and six times as near,
 * at five thresholds. Judges gauss from two directions; with the argument --every, as in
 * long_gl_holes, gauss and box from all. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/hole_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/support/coverage.h"
#include "tests/support/views.h"

enum { SIZE = 512, PIXELS = SIZE * SIZE, THRESHOLDS = 5, NEAR = 6 };
static const double thresholds[THRESHOLDS] = {0.5, 1.0, 2.0, 4.0, 8.0};

/* A pixel is up to 0.7 from a place in it, and so is another one: 1.5 in all. */
#define ROUNDING_PX 1.5
/* The least ellipse, of 1.25 pixels, and half a pixel. */
#define LEAST_ELLIPSE_PX 2.0
/* The radius of discs at a hole's border, in cells (grid_leaf.c). */
#define BORDER_RADIUS 0.75
/* The share of pixels that must be drawn and may lie farther, no farther than so many limits. Of
 * what is drawn, none may. */
#define FAR_SHARE 1e-5
#define FARTHEST 1.5
/* Where holes grow, pull moves small discs beside large ones inwards: more pixels lie farther. */
#define FAR_SHARE_GROWING 1e-3
#define FARTHEST_GROWING 2.5
/* What is then drawn over missing samples, from 26 directions, up to FARTHEST limits. */
#define FILLED_SHARE_GROWING 2e-5
/* Near the edge of a picture the nearest place may lie beyond it, and a disc whose centre lies
 * beyond it is not drawn. At 8 px such discs reached 25 px into pictures, splats too. */
#define EDGE_PX 64

static bool everything;
static bool grow; /* the models that are judged were made with --holes grow */

typedef struct truth {
    triangles_mesh must, may; /* what must be drawn; what may be, narrow holes closed */
} truth;

/* Pixels, those that lie too far from the others, and the greatest distance, in pixels and in
 * limits. */
typedef struct tally {
    size_t pixels, far;
    double greatest_px, greatest;
} tally;

/* Adds how far the pixels of mask `of` lie from those of `from`. */
static void measure(const uint8_t *of, const uint8_t *from, double limit_px, int edge, tally *sum)
{
    double *distance = calloc(PIXELS, sizeof *distance);
    assert_non_null(distance);
    check_ok(coverage_distance(from, SIZE, SIZE, distance, err));
    for (int y = edge; y < SIZE - edge; y++)
        for (int x = edge; x < SIZE - edge; x++) {
            const int i = y * SIZE + x;
            if (!of[i])
                continue;
            sum->pixels++;
            sum->far += distance[i] > limit_px;
            sum->greatest_px = fmax(sum->greatest_px, distance[i]);
            sum->greatest = fmax(sum->greatest, distance[i] / limit_px);
        }
    free(distance);
}

/* Marks the pixels of the mesh, and those of its samples: some are in no triangle. Returns how many
 * pixels the nearest cell is wide, at most. */
static double mark(const triangles_mesh *mesh, const prep_cloud *cloud, const stp_view *view,
                   uint8_t *mask)
{
    triangles_picture picture;
    double nearest = INFINITY;
    check_ok(triangles_draw(&picture, mesh, view, err));
    triangles_mask(&picture, mask);
    triangles_destroy(&picture);
    for (int i = 0; i < HOLE_COUNT; i++) {
        const stp_dvec3 p = reference_to_eye(view, cloud->points[i].position);
        const double u = 0.5 * SIZE - view->f * p.x / p.z, v = 0.5 * SIZE - view->f * p.y / p.z;
        if (cloud->points[i].reject != STP_REJECT_NONE ||
            !(u >= 0.0 && u < SIZE && v >= 0.0 && v < SIZE))
            continue;
        mask[(int)v * SIZE + (int)u] = 1;
        nearest = fmin(nearest, -p.z);
    }
    return view->f / nearest;
}

typedef struct shot {
    double threshold_px, cell_px;
    int edge;
    uint8_t *must, *may;
} shot;

static void judge_shot(gl_fixture *f, const stp_view *view, const shot *s,
                       stp_reconstruct reconstruct, tally sums[2])
{
    const stp_draw_params params = {.threshold_px = s->threshold_px, .reconstruct = reconstruct};
    check_ok(stp_renderer_draw(f->renderer, view, &params, NULL, err));
    uint8_t *drawn = gl_fixture_mask(f, view);
    measure(s->must, drawn, s->threshold_px + ROUNDING_PX, s->edge, &sums[0]);
    const double closed_px = grow ? 0.0 : s->threshold_px;
    measure(drawn, s->may, closed_px + LEAST_ELLIPSE_PX + BORDER_RADIUS * s->cell_px, s->edge,
            &sums[1]);
    free(drawn);
}

/* Draws all directions, all of the grid or near its middle, and adds by threshold what must be
 * drawn and what is. */
static void judge_views(gl_fixture *f, const truth *t, const prep_cloud *cloud, int nearer,
                        stp_reconstruct reconstruct, tally sums[THRESHOLDS][2])
{
    shot s = {
        .edge = nearer > 1 ? EDGE_PX : 0, .must = calloc(PIXELS, 1), .may = calloc(PIXELS, 1)};
    assert_true(s.must != NULL && s.may != NULL);
    for (int i = 0; i < VIEWS_DIRECTIONS; i++) {
        if (!everything && i != 21 && i != 23) /* from above; from the side */
            continue;
        stp_view view = views_get(i, &f->model->ball, NULL, 0, SIZE, SIZE);
        view.f *= nearer;
        s.cell_px = mark(&t->must, cloud, &view, s.must);
        (void)mark(&t->may, cloud, &view, s.may);
        for (int k = 0; k < THRESHOLDS; k++) {
            s.threshold_px = thresholds[k];
            judge_shot(f, &view, &s, reconstruct, sums[k]);
        }
    }
    free(s.must);
    free(s.may);
}

/* Prints the figures of one kind of picture; returns whether the promise is kept. */
static bool is_kept(const char *name, int nearer, bool box, tally sums[THRESHOLDS][2])
{
    bool kept = true;
    for (int k = 0; k < THRESHOLDS; k++) {
        const tally *lost = &sums[k][0], *filled = &sums[k][1];
        print_message(
            "%s%s, %d times as near, %s, %g px: %zu of %zu lost, up to %.2f px; %zu of %zu "
            "filled, up to %.2f px\n",
            name, grow ? ", growing" : "", nearer, box ? "box" : "gauss", thresholds[k], lost->far,
            lost->pixels, lost->greatest_px, filled->far, filled->pixels, filled->greatest_px);
        kept &= lost->pixels > 10000 && lost->greatest <= (grow ? FARTHEST_GROWING : FARTHEST) &&
                (double)lost->far <= (grow ? FAR_SHARE_GROWING : FAR_SHARE) * (double)lost->pixels;
        kept &= filled->pixels > 10000 && filled->greatest <= (grow ? FARTHEST : 1.0) &&
                (double)filled->far <= (grow ? FILLED_SHARE_GROWING : 0.0) * (double)filled->pixels;
    }
    return kept;
}

static void judge(const char *name, hole_mask *missing)
{
    gl_fixture f = {0};
    stp_prep_stats stats;
    prep_cloud cloud = hole_cloud(missing);
    truth t = {hole_mesh(missing, false), hole_mesh(missing, !grow)};
    const stp_prep_params params = {.holes_grow = grow};
    bool kept = true;
    check_ok(prep_cloud_run(&cloud, "holes.stipple", 2, &params, &stats, err));
    gl_fixture_open(&f, "holes.stipple", NULL);
    for (int box = 0; box < (everything ? 2 : 1); box++)
        for (int nearer = 1; nearer <= NEAR; nearer += NEAR - 1) {
            tally sums[THRESHOLDS][2] = {{{0}}};
            judge_views(&f, &t, &cloud, nearer, box ? STP_RECONSTRUCT_BOX : STP_RECONSTRUCT_GAUSS,
                        sums);
            kept &= is_kept(name, nearer, box, sums);
        }
    gl_fixture_close(&f);
    hole_mesh_clear(&t.must);
    hole_mesh_clear(&t.may);
    free(cloud.points);
    assert_true(kept);
}

static void scattered(void **state)
{
    grow = *state != NULL;
    judge("scattered", hole_scattered);
}

static void stripes(void **state)
{
    grow = *state != NULL;
    judge("stripes", hole_stripes);
}

static void discs(void **state)
{
    grow = *state != NULL;
    judge("discs", hole_discs);
}

/* The same discs as missing pixels of a camera's image, from the camera. */
static void image(void **state)
{
    enum { FOCUS = 600 };
    static const stp_dvec3 station = {0.0, 0.0, 0.0};
    static const stp_camera camera = {.look = {0.0, 0.0, 1.0}, .up = {0.0, -1.0, 0.0}};
    gl_fixture f = {0};
    stp_prep_stats stats;
    stp_view view;
    tally sums[THRESHOLDS][2] = {{{0}}};
    prep_cloud cloud = hole_cloud(hole_discs);
    uint8_t *valid = calloc(PIXELS, 1);
    const stp_prep_params params = {.holes_grow = true};
    (void)state;
    assert_non_null(valid);
    grow = true;
    for (int i = 0; i < HOLE_COUNT; i++) {
        const double depth = 500.0 + 3.0 * cloud.points[i].position.z;
        const stp_dvec3 ray = {(i % SIZE + 0.5 - SIZE / 2) / FOCUS,
                               (i / SIZE + 0.5 - SIZE / 2) / FOCUS, 1.0};
        cloud.points[i].position = stp_dvec3_scale(ray, depth);
        cloud.points[i].normal = (vec3s){{0.0f, 0.0f, 0.0f}};
        cloud.points[i].station = 1;
        valid[(SIZE - 1 - i / SIZE) * SIZE + i % SIZE] = cloud.points[i].reject == STP_REJECT_NONE;
    }
    cloud.raster = (stp_scan_raster){0};
    cloud.image_count = 1;
    cloud.image = (stp_scan_grid){.columns = SIZE, .rows = SIZE};
    cloud.stations = &station;
    check_ok(prep_cloud_run(&cloud, "holes.stipple", 2, &params, &stats, err));
    gl_fixture_open(&f, "holes.stipple", NULL);
    stp_camera from = camera;
    from.fovy_deg = 2.0 * atan(0.5 * SIZE / FOCUS) * 180.0 / M_PI;
    check_ok(stp_view_create(&view, &from, &f.model->ball, SIZE, SIZE, err));
    for (int k = 0; k < THRESHOLDS; k++)
        judge_shot(
            &f, &view,
            &(shot){.threshold_px = thresholds[k], .cell_px = M_SQRT2, .must = valid, .may = valid},
            STP_RECONSTRUCT_GAUSS, sums[k]);
    const bool kept = is_kept("image", 1, false, sums);
    gl_fixture_close(&f);
    free(valid);
    free(cloud.points);
    assert_true(kept);
}

int main(int argc, char **argv)
{
    everything = argc > 1 && strcmp(argv[1], "--every") == 0;
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scattered),
        cmocka_unit_test(stripes),
        cmocka_unit_test(discs),
        cmocka_unit_test_prestate(scattered, &grow),
        cmocka_unit_test_prestate(stripes, &grow),
        cmocka_unit_test_prestate(discs, &grow),
        cmocka_unit_test(image),
    };
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}
