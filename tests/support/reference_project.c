/* Projects samples to pixels: "Projection" of shaders/README.md. */
#include "tests/support/reference_parts.h"

#include "formats/chunk/sample/sample.h"

#include <math.h>

#define EXTENT_FLOOR_PX 1.25
/* The share of a disc's radius that is drawn if a pixel sees all ellipses around it. */
#define SEEN_PART 0.85
#define SLOPE_LIMIT 5.0

/* The depth of a pixel's interval. */
static double depth_extent(const stp_view *view, double radius, double cosine, double depth)
{
    double k = fmin(1.0, fabs(cosine));
    double slope = fmin(SLOPE_LIMIT, sqrt(1.0 - k * k) / fmax(k, 1e-3));
    return fmax(radius, EXTENT_FLOOR_PX * slope / reference_pixels_per_unit(view, depth));
}

bool reference_sample(const reference_pyramid *pyramid, const reference_disc *disc,
                      reference_pixel *out)
{
    const stp_view *view = &pyramid->view;
    bool alone = pyramid->filter == REFERENCE_SPLAT && !disc->wide; /* a vertex is a point */
    bool faces = !disc->has_normal || (alone && disc->kind == STP_KIND_TUBE);
    unsigned kind = alone && disc->kind != STP_KIND_POLYGON ? STP_KIND_SURFACE : disc->kind;
    bool tube = kind == STP_KIND_TUBE, point = kind == STP_KIND_SURFACE;
    double radius = disc->radius * (reference_sees_all(pyramid) && point ? SEEN_PART : 1.0);
    double depth = -disc->position.z;
    if (tube && faces)
        kind = STP_KIND_SURFACE;
    if (!(depth > view->near_depth))
        return false;
    double scale = reference_pixels_per_unit(view, depth);
    double u = stp_view_axis_x(view) + scale * disc->position.x;
    double v = stp_view_axis_y(view) + scale * disc->position.y;
    if (!disc->wide && !(u >= 0.0 && u < view->width && v >= 0.0 && v < view->height))
        return false;
    stp_dvec3 w =
        view->orthographic ? (stp_dvec3){0.0, 0.0, -1.0} : stp_dvec3_normalize(disc->position);
    stp_dvec3 n = disc->normal;
    bool oriented = !faces && disc->oriented;
    double away = faces ? 0.0 : stp_dvec3_dot(n, w);
    if (disc->culled && !disc->seen_through && away >= REFERENCE_CULL_COSINE)
        return false;
    if (faces) {
        n = stp_dvec3_scale(w, -1.0);
    } else if (disc->culled && away > 0.0 && away <= REFERENCE_CULL_COSINE) {
        n = stp_dvec3_sub(n, stp_dvec3_scale(w, 2.0 * away));
    } else if (away > 0.0) {
        n = stp_dvec3_scale(n, -1.0);
        oriented = false;
    }
    *out = (reference_pixel){
        .normal = n,
        .radius = radius,
        .z_min = depth,
        .z_max = depth + depth_extent(view, radius, tube ? 1.0 : stp_dvec3_dot(n, w), depth),
        .dx = u,
        .dy = v,
        .rgb = {disc->rgb[0], disc->rgb[1], disc->rgb[2]},
        .tag = 1 + (int)kind + (oriented ? 0 : 8),
    };
    return true;
}

static void project_disc(reference_pyramid *pyramid, const reference_disc *disc)
{
    reference_pixel sample;
    if (!reference_sample(pyramid, disc, &sample))
        return;
    if (!(sample.dx >= 0.0 && sample.dx < pyramid->view.width && sample.dy >= 0.0 &&
          sample.dy < pyramid->view.height))
        return; /* a ribbon's, at the rim */
    int at = (int)sample.dy * pyramid->view.width + (int)sample.dx;
    reference_pixel *pixel = &pyramid->levels[0].pulled[at];
    if (pixel->tag != 0 && pixel->z_min <= sample.z_min)
        return;
    sample.dx -= floor(sample.dx) + 0.5;
    sample.dy -= floor(sample.dy) + 0.5;
    *pixel = sample;
}

void reference_project(reference_pyramid *pyramid, const reference_disc *discs, size_t count)
{
    for (size_t i = 0; i < count; i++)
        project_disc(pyramid, &discs[i]);
}
