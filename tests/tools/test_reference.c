/* Tests the CPU reference of the reconstruction against results known by hand. */
#include "tests/support/check.h"
#include "tests/support/reference.h"

/* Draws discs with all possible levels, or with L for the greatest radius in pixels. */
static reference_pyramid draw(const stp_view *view, bool box, const reference_disc *discs,
                              size_t count, double radius_px)
{
    reference_pyramid p;
    int levels = reference_level_count(radius_px, view->width, view->height);
    check_ok(reference_create(&p, view, box, levels, err));
    reference_project(&p, discs, count);
    reference_pull(&p);
    reference_push(&p);
    return p;
}

static const reference_pixel *at(const reference_pyramid *p, int x, int y)
{
    return &p->levels[0].finished[y * p->levels[0].width + x];
}

static size_t covered(const reference_pyramid *p)
{
    size_t count = 0;
    for (int i = 0; i < p->levels[0].width * p->levels[0].height; i++)
        count += p->levels[0].finished[i].tag != 0;
    return count;
}

static reference_disc disc_at(double x, double y, double depth, double radius)
{
    return (reference_disc){.position = {x, y, -depth},
                            .normal = {0.0, 0.0, 1.0},
                            .radius = radius,
                            .rgb = {1.0, 0.5, 0.25},
                            .has_normal = true,
                            .oriented = true,
                            .culled = true};
}

/* One disc that faces the eye: box filters must cover all pixels inside the circle and none
 * outside, about pi r^2. */
static void one_disc_is_a_circle(void **state)
{
    (void)state;
    stp_view view = check_view(128, 128, 100.0, false);
    for (int k = 0; k < 64; k++) {
        double radius_px = 20.0;
        double cx = 64.0 + (k % 8) / 8.0 + 0.03, cy = 64.0 + (k / 8) / 8.0 + 0.07;
        reference_disc disc =
            disc_at((cx - 64.0) * 0.02, (cy - 64.0) * 0.02, 2.0, radius_px * 0.02);
        disc.normal = stp_dvec3_normalize(stp_dvec3_scale(disc.position, -1.0));
        reference_pyramid p = draw(&view, true, &disc, 1, radius_px);
        size_t inside = 0;
        for (int y = 0; y < 128; y++)
            for (int x = 0; x < 128; x++) {
                double r = hypot(x + 0.5 - cx, y + 0.5 - cy);
                bool is_covered = at(&p, x, y)->tag != 0;
                inside += r <= radius_px - 0.05;
                if (r <= radius_px - 0.05 && !is_covered)
                    fail_msg("box: pixel %d %d at %.2f of %g is missing", x, y, r, radius_px);
                if (r > radius_px + 0.05 && is_covered)
                    fail_msg("box: pixel %d %d at %.2f of %g is covered", x, y, r, radius_px);
            }
        assert_in_range(inside, 1200, 1300); /* pi 20^2 = 1256.6 */
        check_near((double)covered(&p), M_PI * radius_px * radius_px, 30.0);
        reference_destroy(&p);
    }
}

/* MKC08 also asks in the pull whether the ellipse reaches, so a lone disc may lose its rim. It
 * never covers more than the circle, and always a circle of half the radius. */
static void gauss_stays_inside_box(void **state)
{
    (void)state;
    stp_view view = check_view(96, 96, 100.0, false);
    for (int k = 0; k < 256; k++) {
        reference_disc disc = disc_at(0.02 * (k % 16), 0.02 * (k / 16), 2.0, 0.4);
        reference_pyramid box = draw(&view, true, &disc, 1, 20.0);
        reference_pyramid gauss = draw(&view, false, &disc, 1, 20.0);
        int cx = 48 + k % 16, cy = 48 + k / 16;
        for (int y = 0; y < 96; y++)
            for (int x = 0; x < 96; x++) {
                assert_true(at(&gauss, x, y)->tag == 0 || at(&box, x, y)->tag != 0);
                if (hypot(x - cx, y - cy) < 10.0)
                    assert_true(at(&gauss, x, y)->tag != 0);
            }
        reference_destroy(&box);
        reference_destroy(&gauss);
    }
}

/* A disc turned by 60 degrees about y: its half-axes are r / 2 along x and r along y. */
static void ellipse_axes(void **state)
{
    (void)state;
    const reference_pyramid pyramid = {.view = check_view(101, 101, 50.0, true)};
    reference_pixel p = {.normal = {sqrt(0.75), 0.0, 0.5}, .radius = 0.4, .z_min = 2.0, .tag = 1};
    check_near(reference_ellipse(&pyramid, &p, 50.5, 50.5, 10.0, 0.0), 1.0, 1e-12);
    check_near(reference_ellipse(&pyramid, &p, 50.5, 50.5, 0.0, 20.0), 1.0, 1e-12);
    check_near(reference_ellipse(&pyramid, &p, 50.5, 50.5, 5.0, 0.0), 0.25, 1e-12);
    /* edge on, and too small: the floor is 1.25 pixels */
    p.normal = (stp_dvec3){1.0, 0.0, 0.0};
    check_near(reference_ellipse(&pyramid, &p, 50.5, 50.5, 1.25, 0.0), 1.0, 1e-2);
    check_near(reference_ellipse(&pyramid, &p, 50.5, 50.5, 0.0, 20.0), 1.0, 1e-12);
    p.radius = 0.01;
    check_near(reference_ellipse(&pyramid, &p, 50.5, 50.5, 0.0, 1.25), 1.0, 1e-12);
    /* |delta|^2 + (delta.n)^2 / k'^2 with k' = 1 */
    check_near(reference_ellipse(&pyramid, &p, 50.5, 50.5, 0.75, 1.0), 1.36, 1e-12);
    /* no radius */
    p.radius = 0.0;
    assert_true(isinf(reference_ellipse(&pyramid, &p, 50.5, 50.5, 0.6, 0.0)));
    check_near(reference_ellipse(&pyramid, &p, 50.5, 50.5, 0.0, 0.0), 0.0, 0.0);
}

/* In perspective, the rim of a disc, projected point by point, must be the rim of the form, on the
 * axis and off it. */
static void projected_rim(void **state)
{
    (void)state;
    const reference_pyramid pyramid = {.view = check_view(101, 101, 50.0, false)};
    for (int k = 0; k < 12; k++) {
        stp_dvec3 centre = {0.15 * (k % 4) * 2.0, -0.2 * (k / 4) * 2.0, -2.0};
        stp_dvec3 n = stp_dvec3_normalize((stp_dvec3){0.5 - 0.3 * (k % 3), 0.2, 1.0});
        reference_pixel p = {.normal = n, .radius = 0.4, .z_min = 2.0, .tag = 1};
        stp_dvec3 u = stp_dvec3_normalize(stp_dvec3_cross(n, (stp_dvec3){0.0, 1.0, 0.0}));
        stp_dvec3 v = stp_dvec3_cross(n, u);
        double cx = 50.5 + 25.0 * centre.x, cy = 50.5 + 25.0 * centre.y;
        for (int i = 0; i < 16; i++) {
            stp_dvec3 rim = centre;
            rim = stp_dvec3_add(rim, stp_dvec3_scale(u, 0.4 * cos(i * M_PI / 8.0)));
            rim = stp_dvec3_add(rim, stp_dvec3_scale(v, 0.4 * sin(i * M_PI / 8.0)));
            double x = 50.5 - 50.0 * rim.x / rim.z - cx, y = 50.5 - 50.0 * rim.y / rim.z - cy;
            check_near(reference_ellipse(&pyramid, &p, cx, cy, x, y), 1.0, 1e-12);
        }
    }
}

/* The nearer of two discs hides the other where they overlap, in either order of drawing. */
static void front_wins(void **state)
{
    (void)state;
    stp_view view = check_view(64, 64, 64.0, true);
    for (int order = 0; order < 2; order++) {
        reference_disc discs[2] = {disc_at(-0.05, 0.0, 2.0 - 1.0 * order, 0.2),
                                   disc_at(0.05, 0.0, 1.0 + 1.0 * order, 0.2)};
        discs[0].rgb[0] = 0.0;
        reference_pyramid p = draw(&view, true, discs, 2, 12.8);
        const reference_pixel *middle = at(&p, 32, 32);
        check_near(middle->z_min, 1.0, 1e-9);
        check_near(middle->rgb[0], order ? 0.0 : 1.0, 1e-9);
        reference_destroy(&p);
    }
    /* in one pixel the nearer disc wins; among equals the first */
    reference_disc same[3] = {disc_at(0.01, 0.01, 2.0, 0.0), disc_at(0.01, 0.01, 1.5, 0.0),
                              disc_at(0.012, 0.01, 1.5, 0.0)};
    same[1].rgb[2] = 0.75;
    reference_pyramid p = draw(&view, false, same, 3, 0.0);
    assert_int_equal(covered(&p), 1);
    check_near(at(&p, 32, 32)->rgb[2], 0.75, 0.0);
    reference_destroy(&p);
}

/* Makes a grid of discs on a plane z(x), so that every pixel's depth is known. */
static size_t plane_discs(reference_disc *out, int n, double spacing, double slope, double depth,
                          const double rgb[3])
{
    size_t count = 0;
    for (int j = 0; j < n; j++)
        for (int i = 0; i < n; i++) {
            double x = (i - 0.5 * n + 0.37) * spacing / sqrt(1.0 + slope * slope);
            double y = (j - 0.5 * n + 0.41) * spacing;
            out[count] = disc_at(x, y, depth + slope * x, 1.7 * spacing);
            out[count].normal = stp_dvec3_normalize((stp_dvec3){slope, 0.0, 1.0});
            memcpy(out[count].rgb, rgb, sizeof out[count].rgb);
            count++;
        }
    return count;
}

/* A plane at 45 degrees must be closed, with the right depth, normal and colour everywhere. */
static void slanted_plane_is_closed(void **state)
{
    (void)state;
    static reference_disc discs[120 * 120];
    const double rgb[3] = {0.2, 0.6, 0.9};
    for (int mode = 0; mode < 4; mode++) {
        stp_view view = check_view(257, 129, 100.0, mode & 1);
        double spacing = 0.06; /* 3 pixels */
        size_t count = plane_discs(discs, 120, spacing, 1.0, 3.5, rgb);
        if (view.orthographic)
            view.f = 50.0;
        reference_pyramid p = draw(&view, mode & 2, discs, count, 20.0);
        for (int y = 20; y < 109; y++)
            for (int x = 90; x < 167; x++) {
                const reference_pixel *q = at(&p, x, y);
                double u = (x + 0.5 - 128.5) / view.f;
                double depth = view.orthographic ? 3.5 + u : 3.5 / (1.0 - u);
                if (q->tag == 0)
                    fail_msg("mode %d: a hole at %d %d", mode, x, y);
                /* within the disc's reach, and its centre's distance from the pixel's */
                check_near(q->z_min, depth, 1.7 * spacing + depth * depth / 3.5 / view.f);
                check_near(q->normal.x, sqrt(0.5), 1e-9);
                for (int k = 0; k < 3; k++)
                    check_near(q->rgb[k], rgb[k], 1e-9);
                assert_int_equal((q->tag - 1) & 15, 0);
            }
        reference_destroy(&p);
    }
}

/* A sparse layer lies a radius and more in front of a dense one: the front layer must be closed,
 * and the two may not mix. */
static void two_layers_stay_apart(void **state)
{
    (void)state;
    static reference_disc discs[2 * 120 * 120];
    const double front[3] = {1.0, 0.0, 0.0}, back[3] = {0.0, 1.0, 0.0};
    stp_view view = check_view(128, 128, 50.0, true);
    for (int box = 0; box < 2; box++) {
        size_t count = plane_discs(discs, 40, 0.1, 0.0, 2.0, front);
        count += plane_discs(discs + count, 120, 0.03, 0.0, 2.3, back);
        reference_pyramid p = draw(&view, box, discs, count, 6.0);
        for (int y = 16; y < 112; y++)
            for (int x = 16; x < 112; x++) {
                check_near(at(&p, x, y)->z_min, 2.0, 1e-9);
                check_near(at(&p, x, y)->rgb[0], 1.0, 1e-9);
                check_near(at(&p, x, y)->rgb[1], 0.0, 1e-9);
            }
        reference_destroy(&p);
    }
}

/* Known orientation culls. Unknown normals face the eye and are two-sided. Opposed two-sided
 * normals must not cancel. */
static void sides(void **state)
{
    (void)state;
    stp_view view = check_view(32, 32, 32.0, false);
    reference_disc disc = disc_at(0.0, 0.0, 2.0, 0.3);
    disc.normal = (stp_dvec3){0.0, 0.6, -0.8};
    reference_pyramid p = draw(&view, false, &disc, 1, 5.0);
    assert_int_equal(covered(&p), 0);
    reference_destroy(&p);
    disc.culled = false; /* known, but seen from behind: shows the visible side */
    p = draw(&view, false, &disc, 1, 5.0);
    assert_true(covered(&p) > 20);
    check_near(at(&p, 16, 16)->normal.z, 0.8, 1e-12);
    assert_int_equal(at(&p, 16, 16)->tag, 9);
    reference_destroy(&p);
    reference_disc pair[2] = {disc, disc_at(0.08, 0.0, 2.0, 0.3)};
    pair[0].normal = (stp_dvec3){1.0, 0.0, 0.05};
    pair[1].normal = (stp_dvec3){-1.0, 0.0, 0.05};
    pair[1].oriented = false;
    p = draw(&view, true, pair, 2, 5.0);
    for (int i = 0; i < 32 * 32; i++)
        if (p.levels[0].finished[i].tag != 0)
            assert_true(fabs(p.levels[0].finished[i].normal.x) > 0.9);
    reference_destroy(&p);
    disc.has_normal = false;
    p = draw(&view, false, &disc, 1, 5.0);
    check_near(at(&p, 16, 16)->normal.z, 1.0, 1e-12);
    assert_int_equal(at(&p, 16, 16)->tag, 9);
    reference_destroy(&p);
}

static void all_finite(const reference_pyramid *p)
{
    for (int l = 0; l <= p->level_count; l++)
        for (int i = 0; i < p->levels[l].width * p->levels[l].height; i++) {
            const reference_pixel *q = &p->levels[l].finished[i];
            assert_true(stp_dvec3_finite(q->normal) && isfinite(q->radius));
            assert_true(isfinite(q->z_min) && isfinite(q->z_max) && q->z_min <= q->z_max);
            assert_true(isfinite(q->dx) && isfinite(q->dy));
            for (int k = 0; k < 3; k++)
                assert_true(q->rgb[k] >= 0.0 && q->rgb[k] <= 1.0);
        }
}

/* Any viewport, and extreme discs: no NaN may occur, and invalid discs are dropped. */
static void odd_viewports_and_odd_discs(void **state)
{
    (void)state;
    static const int sizes[][2] = {{1, 1}, {3, 7}, {257, 129}, {64, 64}, {1, 50}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int mode = 0; mode < 4; mode++) {
            stp_view view = check_view(sizes[s][0], sizes[s][1], 20.0, mode & 1);
            reference_disc discs[] = {
                disc_at(0.01, 0.01, 2.0, 0.0), disc_at(0.0, 0.0, 2.5, 0.1),
                disc_at(0.0, 0.0, -2.0, 1.0),  disc_at(0.0, 0.0, 0.0, 1.0),
                disc_at(0.02, 0.02, 1.8, 1e6), disc_at(1e9, 1e9, 2.0, 1.0),
                disc_at(0.0, 0.01, 1e-4, 1.0), disc_at(-0.3, 0.3, 2.0, 0.2),
                disc_at(0.3, -0.3, 1.9, 0.2),  disc_at(0.0, 0.0, 1e12, 1e12),
            };
            for (size_t i = 7; i < 9; i++)
                discs[i].normal = (stp_dvec3){0.0, 0.0, 0.0};
            discs[7].oriented = false;
            reference_pyramid p =
                draw(&view, mode & 2, discs, sizeof discs / sizeof *discs, INFINITY);
            assert_int_equal(1 << p.level_count >= sizes[s][0], 1);
            all_finite(&p);
            assert_true(covered(&p) > 0);
            reference_destroy(&p);
            /* the disc larger than the screen must fill it */
            p = draw(&view, mode & 2, &discs[4], 1, INFINITY);
            assert_int_equal(covered(&p), sizes[s][0] * sizes[s][1]);
            reference_destroy(&p);
        }
}

/* Four small discs on the corners of a pixel of level 1: the disc that stands for them must have
 * their centre and their second moment. With box (MKC07) its radius is their mean radius. */
static void pulled_radii(void **state)
{
    (void)state;
    stp_view view = check_view(8, 8, 1.0, true);
    reference_disc discs[4];
    const double a = 0.25, r = 3.0; /* from the middle along each axis; radius; pixels */
    for (int k = 0; k < 4; k++)
        discs[k] =
            disc_at(k & 1 ? 1.0 + a : 1.0 - a, k & 2 ? 1.0 + a : 1.0 - a, 2.0 + 0.1 * k, r + k);
    static const reference_filter filters[] = {REFERENCE_GAUSS, REFERENCE_BOX, REFERENCE_TEMPLATE3};
    const double square =
        (r * r + (r + 1.0) * (r + 1.0) + (r + 2.0) * (r + 2.0) + (r + 3.0) * (r + 3.0)) / 4.0;
    for (int i = 0; i < 3; i++) {
        bool moment = filters[i] != REFERENCE_BOX;
        double part =
            filters[i] == REFERENCE_TEMPLATE3 ? 0.85 : 1.0; /* of the radius, "Templates" */
        reference_pyramid p;
        check_ok(reference_create(&p, &view, filters[i], 1, err));
        reference_project(&p, discs, 4);
        reference_pull(&p);
        const reference_pixel *q = &p.levels[1].pulled[2 * 4 + 2];
        check_near(q->radius, moment ? sqrt(part * part * square + 2.0 * 2.0 * a * a) : r + 1.5,
                   1e-12);
        check_near(q->dx, 0.0, 1e-12);
        check_near(q->dy, 0.0, 1e-12);
        check_near(q->z_min, 2.0, 1e-12);
        check_near(q->z_max, 2.3 + part * (r + 3.0), 1e-12);
        assert_int_equal(q->tag, 1 + 16);
        reference_destroy(&p);
    }
    /* a grazing disc's interval is the descent of its plane over 1.25 pixels, at most 5 per
     * pixel */
    reference_disc disc = disc_at(0.3, 0.2, 2.0, 0.1);
    disc.normal = (stp_dvec3){0.6, 0.0, 0.8};
    reference_pyramid p = draw(&view, false, &disc, 1, 0.0);
    check_near(at(&p, 4, 4)->z_max, 2.0 + 1.25 * 0.75, 1e-12);
    check_near(at(&p, 4, 4)->dx, -0.2, 1e-12);
    check_near(at(&p, 4, 4)->dy, -0.3, 1e-12);
    reference_destroy(&p);
    disc.normal = stp_dvec3_normalize((stp_dvec3){1.0, 0.0, 0.01});
    p = draw(&view, false, &disc, 1, 0.0);
    check_near(at(&p, 4, 4)->z_max, 2.0 + 1.25 * 5.0, 1e-12);
    reference_destroy(&p);
}

/* Four discs around pixel (1, 1) of 4 x 4, the nearest with q = 2.7 there: a gap. If the plane of
 * one meets the pixel's ray behind the eye, only three lie around it, which reach as far as q = 2.
 */
static void gaps(void **state)
{
    (void)state;
    const double f = 100.0, depth = 2.0, unit = depth / f;
    stp_view view = check_view(4, 4, f, false);
    reference_disc discs[4];
    for (int k = 0; k < 4; k++) {
        double x = k & 1 ? 3.9 : 0.05, y = k & 2 ? 3.9 : 0.05;
        discs[k] = disc_at((x - 2.0) * unit, (y - 2.0) * unit, depth, unit);
    }
    for (int behind = 0; behind < 2; behind++) {
        reference_pyramid p;
        if (behind) {
            discs[3].normal = stp_dvec3_normalize((stp_dvec3){-0.7, -0.7, -0.02});
            discs[3].radius = 100.0 * unit;
        }
        check_ok(reference_create(&p, &view, REFERENCE_BOX, 1, err));
        reference_project(&p, discs, 4);
        reference_pull(&p);
        reference_push(&p);
        for (int k = 0; k < 4; k++)
            assert_int_not_equal(p.levels[1].finished[k].tag, 0);
        assert_int_equal(at(&p, 1, 1)->tag != 0, !behind);
        reference_destroy(&p);
    }
}

/* Averaged values must name their pyramid level; measured pixels have 0. */
static void source_levels(void **state)
{
    (void)state;
    stp_view view = check_view(64, 64, 32.0, true);
    reference_disc disc = disc_at(0.01, 0.01, 2.0, 0.5);
    reference_pyramid p = draw(&view, true, &disc, 1, 16.0);
    assert_int_equal((at(&p, 32, 32)->tag - 1) >> 4, 0);
    assert_true((at(&p, 40, 32)->tag - 1) >> 4 > 0);
    reference_destroy(&p);
    assert_int_equal(reference_level_count(0.0, 64, 64), 0);
    assert_int_equal(reference_level_count(1.0, 64, 64), 3);
    assert_int_equal(reference_level_count(INFINITY, 257, 129), 9);
    assert_int_equal(reference_level_count(1e9, 1, 1), 0);
}

/* Shading of one pixel on the axis, computed by hand. */
static void shading(void **state)
{
    (void)state;
    stp_view view = check_view(1, 1, 32.0, false);
    reference_disc disc = disc_at(0.0, 0.0, 2.0, 0.1);
    disc.normal = (stp_dvec3){0.6, 0.0, 0.8};
    reference_pyramid p = draw(&view, false, &disc, 1, 0.0);
    double c[4];
    reference_shade_picture(&p, REFERENCE_LAMBERT, c);
    check_near(c[0], 0.05 + 0.85 * 0.8, 1e-12);
    check_near(c[2], 0.25 * (0.05 + 0.85 * 0.8), 1e-12);
    check_near(c[3], 1.0, 0.0);
    reference_shade_picture(&p, REFERENCE_NORMAL, c);
    check_near(c[0], 0.8, 1e-12);
    check_near(c[1], 0.5, 1e-12);
    check_near(c[2], 0.9, 1e-12);
    reference_shade_picture(&p, REFERENCE_DEPTH, c);
    check_near(c[1], 0.5, 1e-12);
    reference_shade_picture(&p, REFERENCE_PHONG, c);
    double length = sqrt(0.35 * 0.35 + 0.45 * 0.45 + 1.0);
    double l[3] = {0.35 / length, 0.45 / length, 1.0 / length};
    double h_length = sqrt(l[0] * l[0] + l[1] * l[1] + (l[2] + 1.0) * (l[2] + 1.0));
    double nl = 0.6 * l[0] + 0.8 * l[2], nh = (0.6 * l[0] + 0.8 * (l[2] + 1.0)) / h_length;
    double light = 0.18 + 0.74 * nl + 0.08 * 0.8 + 0.4 * 0.8 * (1.0 - nl);
    check_near(c[1], 0.5 * light + 0.16 * pow(nh, 40.0), 1e-12);
    reference_destroy(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_disc_is_a_circle),
        cmocka_unit_test(gauss_stays_inside_box),
        cmocka_unit_test(ellipse_axes),
        cmocka_unit_test(projected_rim),
        cmocka_unit_test(front_wins),
        cmocka_unit_test(slanted_plane_is_closed),
        cmocka_unit_test(two_layers_stay_apart),
        cmocka_unit_test(sides),
        cmocka_unit_test(odd_viewports_and_odd_discs),
        cmocka_unit_test(pulled_radii),
        cmocka_unit_test(gaps),
        cmocka_unit_test(source_levels),
        cmocka_unit_test(shading),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
