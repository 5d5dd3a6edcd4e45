/* Coverage of pictures from 26 directions against the true mesh drawn as triangles with the same
 * camera. Failures end the test. */
#ifndef STP_TESTS_GL_COVERAGE_H
#define STP_TESTS_GL_COVERAGE_H

#include "tests/gl_fixture.h"
#include "tests/model_fixture.h"
#include "tests/support/coverage.h"
#include "tests/support/triangles.h"
#include "tests/support/views.h"

#define HOLES_LIMIT 1e-4 /* of the silhouette's pixels */

/* How one kind of picture did over all directions. */
typedef struct coverage_total {
    size_t silhouette, hole_pixels, hole_count, largest_hole, spill, outline, outline_far;
    double worst_far; /* share of one picture's outline that is too far */
    double worst_holes;
} coverage_total;

static inline void gl_coverage_add(coverage_total *sum, const coverage_verdict *v)
{
    sum->silhouette += v->silhouette;
    sum->hole_pixels += v->hole_pixels;
    sum->hole_count += v->hole_count;
    sum->largest_hole = v->largest_hole > sum->largest_hole ? v->largest_hole : sum->largest_hole;
    sum->spill += v->spill;
    sum->outline += v->outline;
    sum->outline_far += v->outline_far;
    sum->worst_far = fmax(sum->worst_far, (double)v->outline_far / (double)v->outline);
    sum->worst_holes = fmax(sum->worst_holes, (double)v->hole_pixels / (double)v->silhouette);
}

static inline void gl_coverage_draw(gl_fixture *f, const triangles_mesh *mesh, double spacing,
                                    int size, double threshold_px, coverage_total *sum)
{
    for (int i = 0; i < VIEWS_DIRECTIONS; i++) {
        stp_view view = views_get(i, &f->model->ball, NULL, 0, size, size);
        /* of the model's middle: what lies nearer is spaced wider, what lies behind closer */
        double middle = 0.5 * (view.ball_near + view.ball_far);
        double spacing_px = spacing * view.f / middle;
        stp_draw_params params = {.threshold_px = threshold_px,
                                  .every_sample = threshold_px == 0.0};
        triangles_picture truth;
        coverage_verdict verdict;
        assert_true(spacing_px < 2.0);
        check_ok(stp_renderer_draw(f->renderer, &view, &params, NULL, err));
        check_ok(triangles_draw(&truth, mesh, &view, err));
        uint8_t *silhouette = calloc((size_t)size, (size_t)size);
        assert_non_null(silhouette);
        triangles_mask(&truth, silhouette);
        uint8_t *mask = gl_fixture_mask(f, &view);
        check_ok(coverage_judge(mask, silhouette, size, size, 1.0 + spacing_px, &verdict, err));
        if (verdict.hole_pixels > 0 || verdict.outline_far * 100 > verdict.outline)
            print_message(
                "  direction %d, %g px: %zu hole pixels in %zu holes, largest %zu; %zu of "
                "%zu outline pixels far, 99 %% within %.2f px (%.2f allowed)\n",
                i, threshold_px, verdict.hole_pixels, verdict.hole_count, verdict.largest_hole,
                verdict.outline_far, verdict.outline, verdict.outline_p99_px, 1.0 + spacing_px);
        gl_coverage_add(sum, &verdict);
        free(mask);
        free(silhouette);
        triangles_destroy(&truth);
    }
}

/* Builds the model and its mesh, draws it at thresholds 0 and 1, and checks the figures. */
static inline void gl_coverage_judge(const char *name, const model_recipe *recipe,
                                     uint64_t triangle_count, int size)
{
    gl_fixture f = {0};
    bool good = true;
    double spacing = model_fixture_build("coverage.stipple", recipe);
    triangles_mesh mesh = model_fixture_mesh(recipe->shape, recipe->point_count, triangle_count);
    gl_fixture_open(&f, "coverage.stipple", NULL);
    for (int threshold = 0; threshold < 2; threshold++) {
        coverage_total sum = {0};
        gl_coverage_draw(&f, &mesh, spacing, size, threshold, &sum);
        print_message(
            "%s, %d pixels square, threshold %d: %zu pixels, %zu hole pixels (%.4f %%) in "
            "%zu holes, largest %zu; %zu spill; %.3f %% of the outline far, at most %.3f "
            "%%\n",
            name, size, threshold, sum.silhouette, sum.hole_pixels,
            100.0 * (double)sum.hole_pixels / (double)sum.silhouette, sum.hole_count,
            sum.largest_hole, sum.spill, 100.0 * (double)sum.outline_far / (double)sum.outline,
            100.0 * sum.worst_far);
        good &= sum.worst_holes <= HOLES_LIMIT && sum.largest_hole <= 1 && sum.worst_far <= 0.01;
    }
    gl_fixture_close(&f);
    model_fixture_mesh_clear(&mesh);
    assert_true(good);
}

#endif
