/* Picks judged by the true mesh, drawn as triangles with the same camera.
 *
 * A pick at a pixel that the mesh covers is right where it finds something, no farther from the
 * true surface than the radius of the sample it names, and not behind the mesh's front at the
 * pixel: what a surface displaced by that radius and half a pixel's diagonal may lie deeper along
 * the ray counts as the front. Failures end the test. */
#ifndef STP_TESTS_GL_PICK_H
#define STP_TESTS_GL_PICK_H

#include "tests/gl_fixture.h"
#include "tests/model_fixture.h"
#include "tests/support/triangles.h"
#include "tests/support/views.h"

#define PICK_SPACING_LIMIT_PX 16.0
#define PICK_LEAST_COSINE 0.1 /* a surface more grazing than this is as deep as one that is so */

typedef struct pick_tally {
    size_t picks, right;
    size_t missed, behind, far, turned; /* why not: nothing found; behind; off; another side */
    size_t interpolated, unnamed;       /* of those found; unnamed: no sample was told */
    double distance_sum;                /* of right ones, in radii */
} pick_tally;

/* What the picks of one view are judged by. */
typedef struct pick_scene {
    gl_fixture *f;
    const triangles_mesh *mesh;
    const gen_surface *surface;
    double spacing; /* of the model's samples */
    stp_view view;
    triangles_picture truth;
} pick_scene;

/* The point of a triangle nearest to p (Ericson, Real-Time Collision Detection, 5.1.5). */
static inline stp_dvec3 pick_on_triangle(stp_dvec3 p, stp_dvec3 a, stp_dvec3 b, stp_dvec3 c)
{
    stp_dvec3 ab = stp_dvec3_sub(b, a), ac = stp_dvec3_sub(c, a);
    stp_dvec3 ap = stp_dvec3_sub(p, a), bp = stp_dvec3_sub(p, b), cp = stp_dvec3_sub(p, c);
    double d1 = stp_dvec3_dot(ab, ap), d2 = stp_dvec3_dot(ac, ap);
    double d3 = stp_dvec3_dot(ab, bp), d4 = stp_dvec3_dot(ac, bp);
    double d5 = stp_dvec3_dot(ab, cp), d6 = stp_dvec3_dot(ac, cp);
    double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    if (d1 <= 0.0 && d2 <= 0.0)
        return a;
    if (d3 >= 0.0 && d4 <= d3)
        return b;
    if (d6 >= 0.0 && d5 <= d6)
        return c;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0)
        return stp_dvec3_add(a, stp_dvec3_scale(ab, d1 / (d1 - d3)));
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0)
        return stp_dvec3_add(a, stp_dvec3_scale(ac, d2 / (d2 - d6)));
    if (va <= 0.0 && d4 >= d3 && d5 >= d6)
        return stp_dvec3_add(
            b, stp_dvec3_scale(stp_dvec3_sub(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6))));
    double sum = va + vb + vc;
    return stp_dvec3_add(
        a, stp_dvec3_add(stp_dvec3_scale(ab, vb / sum), stp_dvec3_scale(ac, vc / sum)));
}

/* Whether the mesh shows its outside at a pixel: a sample's known back is not drawn. */
static inline bool pick_outside(const pick_scene *s, int x, int y)
{
    const triangles_pixel *t = &s->truth.pixels[y * s->truth.width + x];
    if (t->layers == 0)
        return false;
    const uint32_t *corner = s->mesh->triangles[t->triangle];
    const stp_dvec3 *v = s->mesh->positions;
    stp_dvec3 face = stp_dvec3_cross(stp_dvec3_sub(v[corner[1]], v[corner[0]]),
                                     stp_dvec3_sub(v[corner[2]], v[corner[0]]));
    stp_dvec3 way = s->view.orthographic ? stp_dvec3_scale(s->view.back, -1.0)
                                         : stp_dvec3_sub(v[corner[0]], s->view.eye);
    return stp_dvec3_dot(face, way) < 0.0;
}

/* Cosine between the true surface and the ray at a pixel. */
static inline double pick_cosine(const pick_scene *s, const triangles_pixel *t, int x, int y)
{
    stp_dvec3 way = {(x + 0.5 - 0.5 * s->view.width) / s->view.f,
                     (y + 0.5 - 0.5 * s->view.height) / s->view.f, -1.0};
    if (s->view.orthographic)
        way.x = way.y = 0.0;
    return fabs(stp_dvec3_dot(t->normal, stp_dvec3_normalize(way)));
}

/* Pixels a unit is long at the mesh's front. */
static inline double pick_scale(const pick_scene *s, int x, int y)
{
    double depth = s->truth.pixels[y * s->truth.width + x].depth;
    return s->view.orthographic ? s->view.f : s->view.f / depth;
}

/* Distance of a place to what is visible around a pixel, no deeper than so. */
static inline double pick_distance(const pick_scene *s, int x, int y, stp_dvec3 at, double radius,
                                   double deepest)
{
    const triangles_picture *t = &s->truth;
    double least = INFINITY, ppu = pick_scale(s, x, y);
    int reach = (int)fmin(ceil(radius * ppu), t->width) + 1, step = 1 + reach / 40;
    for (int j = y - reach / step * step; j <= y + reach; j += step)
        for (int i = x - reach / step * step; i <= x + reach; i += step) {
            if (i < 0 || j < 0 || i >= t->width || j >= t->height)
                continue;
            const triangles_pixel *p = &t->pixels[j * t->width + i];
            if (p->layers == 0 || p->depth > deepest)
                continue;
            const uint32_t *corner = s->mesh->triangles[p->triangle];
            const stp_dvec3 *v = s->mesh->positions;
            stp_dvec3 on = pick_on_triangle(at, v[corner[0]], v[corner[1]], v[corner[2]]);
            least = fmin(least, stp_dvec3_length(stp_dvec3_sub(on, at)));
        }
    return least;
}

/* Picks a pixel that the mesh covers, and judges it. Returns whether it found the front. */
static inline bool pick_judge(const pick_scene *s, int x, int y, bool sheet, pick_tally *tally)
{
    const triangles_pixel *t = &s->truth.pixels[y * s->truth.width + x];
    stp_pick pick;
    check_ok(stp_renderer_pick(s->f->renderer, x, y, &pick, err));
    tally->picks++;
    if (!pick.hit) {
        tally->missed++;
        return false;
    }
    stp_dvec3 at = stp_view_project(&s->view, pick.position);
    double ppu = s->view.orthographic ? s->view.f : s->view.f / at.z;
    /* where an interpolated pixel has no sample near, the pick is off */
    bool beside = hypot(at.x - x - 0.5, at.y - y - 0.5) >= 3.0 + pick.radius * ppu;
    assert_true(pick.depth <= pick.depth_end);
    assert_int_equal(pick.interpolated, pick.pyramid_level > 0);
    tally->interpolated += pick.interpolated;
    tally->unnamed += pick.chunk == STP_CHUNK_NONE;
    double slack = (pick.radius + M_SQRT1_2 / pick_scale(s, x, y)) /
                   fmax(pick_cosine(s, t, x, y), PICK_LEAST_COSINE);
    double distance = pick_distance(s, x, y, pick.position, pick.radius, t->depth + slack);
    gen_hit hit;
    s->surface->project(s->surface, pick.position, &hit);
    distance = fmin(distance, stp_dvec3_length(stp_dvec3_sub(hit.position, pick.position)));
    /* One side of the sheet is red, the other blue. */
    bool front_side = stp_dvec3_dot(s->view.back, (stp_dvec3){0.0, 0.0, 1.0}) > 0.0;
    bool turned = sheet && (pick.rgb[0] > pick.rgb[2]) != front_side;
    bool behind = at.z > t->depth + slack;
    tally->behind += behind;
    tally->turned += turned && !behind;
    bool off = beside || distance > pick.radius;
    tally->far += !behind && !turned && off;
    if (behind || turned || off)
        return false;
    tally->right++;
    tally->distance_sum += distance / pick.radius;
    return true;
}

static inline uint32_t pick_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* Draws a view and its truth; end it with pick_scene_end. */
static inline void pick_scene_begin(pick_scene *s, const stp_view *view,
                                    const stp_draw_params *params)
{
    s->view = *view;
    check_ok(stp_renderer_draw(s->f->renderer, view, params, NULL, err));
    check_ok(triangles_draw(&s->truth, s->mesh, view, err));
}

static inline void pick_scene_end(pick_scene *s)
{
    triangles_destroy(&s->truth);
}

/* Whether a pixel shows the outside, of which the samples are not so far apart that it is none. */
static inline bool pick_shown(const pick_scene *s, int x, int y)
{
    return pick_outside(s, x, y) && s->spacing * pick_scale(s, x, y) < PICK_SPACING_LIMIT_PX;
}

/* So many picks at random pixels of that kind; none where there are hardly any. */
static inline void pick_at_random(const pick_scene *s, size_t count, bool sheet, uint32_t *random,
                                  pick_tally *tally)
{
    size_t pixels = (size_t)s->view.width * (size_t)s->view.height, covered = 0;
    for (int y = 0; y < s->view.height; y++)
        for (int x = 0; x < s->view.width; x++)
            covered += pick_shown(s, x, y);
    for (size_t k = 0; covered > 200 && k < count;) {
        size_t at = pick_random(random) % pixels;
        int x = (int)at % s->view.width, y = (int)at / s->view.width;
        if (!pick_shown(s, x, y))
            continue;
        pick_judge(s, x, y, sheet, tally);
        k++;
    }
}

static inline void pick_print(const char *name, const pick_tally *t)
{
    print_message("%s: %zu of %zu picks right, %.3f %%; %zu missed, %zu behind, %zu of the other "
                  "side, %zu off; %zu interpolated, %zu without a sample; mean distance %.3f "
                  "radii\n",
                  name, t->right, t->picks, 100.0 * (double)t->right / (double)t->picks, t->missed,
                  t->behind, t->turned, t->far, t->interpolated, t->unnamed,
                  t->distance_sum / (double)t->right);
}

/* Random picks in views all around and close to a model, as many in each, at thresholds 1 and 0. */
static inline pick_tally pick_model(const char *name, const model_recipe *recipe,
                                    uint64_t triangle_count, int size, size_t count)
{
    gl_fixture f = {0};
    pick_tally tally = {0};
    promise_disc *leaves = NULL;
    size_t leaf_count = 0;
    uint32_t random = 1;
    double spacing = model_fixture_build("pick.stipple", recipe);
    gen_surface surface;
    gen_surface_init(&surface, recipe->shape, recipe->point_count, 0);
    triangles_mesh mesh = model_fixture_mesh(recipe->shape, recipe->point_count, triangle_count);
    gl_fixture_open(&f, "pick.stipple", NULL);
    check_ok(promise_load_leaves(f.model->file, &leaves, &leaf_count, err));
    pick_scene s = {.f = &f, .mesh = &mesh, .surface = &surface, .spacing = spacing};
    for (int round = 0; tally.picks < count; round++) {
        int i = round % VIEWS_COUNT;
        stp_view view = views_get(i, &f.model->ball, leaves, leaf_count, size, size);
        view.orthographic = round % 9 == 4;
        if (view.orthographic)
            view.f = 0.45 * size / f.model->ball.radius;
        stp_draw_params params = {.every_sample = round % 4 == 3,
                                  .lod = round % 2 ? STP_LOD_COMPUTE : STP_LOD_GEOMETRY,
                                  .cull = STP_CULL_BACK}; /* of the sheet both sides have samples */
        pick_tally before = tally;
        pick_scene_begin(&s, &view, &params);
        size_t left = count - tally.picks, share = count / VIEWS_COUNT + 1;
        pick_at_random(&s, left < share ? left : share, recipe->shape == GEN_SHEET, &random,
                       &tally);
        pick_scene_end(&s);
        size_t wrong = tally.picks - tally.right - (before.picks - before.right);
        if (wrong > 0)
            print_message("  view %d: %zu wrong, %zu missed, %zu behind, %zu off\n", i, wrong,
                          tally.missed - before.missed, tally.behind - before.behind,
                          tally.far - before.far);
    }
    pick_print(name, &tally);
    free(leaves);
    model_fixture_mesh_clear(&mesh);
    gl_fixture_close(&f);
    return tally;
}

#endif
