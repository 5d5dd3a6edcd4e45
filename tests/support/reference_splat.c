/* Splats on the CPU ("Splatting" in shaders/README.md). */
#include "tests/support/reference_parts.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

/* What a pixel collects from the splats that cover it. */
typedef struct sums {
    reference_pixel front; /* the splat whose interval ends first */
    double end;            /* the end of that interval */
    stp_dvec3 normal;
    double rgb[3], depth, total;
} sums;

/* One splat at pixel (i, j): its q, and its interval from the depth there. */
typedef struct covering {
    const reference_pixel *sample;
    double q, depth, end;
} covering;

static bool is_shape(const reference_pixel *p)
{
    return reference_is_polygon(p) || reference_is_line(p);
}

typedef void visit(sums *pixel, const covering *c, int i, int j);

static void find_front(sums *pixel, const covering *c, int i, int j)
{
    if (pixel->total != 0.0 && pixel->end <= c->end)
        return;
    pixel->total = 1.0; /* something is there */
    pixel->end = c->end;
    pixel->front = *c->sample;
    pixel->front.dx -= i + 0.5;
    pixel->front.dy -= j + 0.5;
}

static void add(sums *pixel, const covering *c, int i, int j)
{
    (void)i;
    (void)j;
    if (c->depth > pixel->end)
        return;
    if (is_shape(c->sample)) { /* it is the front or does not count */
        pixel->total += is_shape(&pixel->front) ? 1.0 : 0.0;
        return;
    }
    double w = exp(-2.0 * c->q);
    pixel->normal = stp_dvec3_add(pixel->normal, stp_dvec3_scale(c->sample->normal, w));
    for (int k = 0; k < 3; k++)
        pixel->rgb[k] += w * c->sample->rgb[k];
    pixel->depth += w * c->depth;
    pixel->total += w;
}

/* The first and the last of `count` pixels in a row that lie between two places, however far off.
 */
static int first_of(double low, int count)
{
    return (int)fmin(fmax(0.0, low), count);
}

static int last_of(double high, int count)
{
    return (int)fmax(fmin(count - 1, high), -1.0);
}

/* Visits the pixels that a disc covers. */
static void rasterise(const reference_pyramid *pyramid, const reference_disc *disc, sums *pixels,
                      visit *each)
{
    const stp_view *view = &pyramid->view;
    reference_pixel p;
    if (disc->presence == REFERENCE_MISSING || !reference_sample(pyramid, disc, &p))
        return;
    /* twice the radius contains the ellipse, unless it comes near the eye */
    double ppu = view->orthographic ? view->f : view->f / p.z_min;
    double radius = reference_radius_px(pyramid, &p);
    double near = view->orthographic ? 1.0 : 1.0 - radius / ppu / p.z_min;
    double reach = near > 0.25 ? 2.0 * radius / near + 1.0 : view->width + view->height;
    int x0 = first_of(p.dx - reach, view->width), x1 = last_of(p.dx + reach, view->width);
    int y0 = first_of(p.dy - reach, view->height), y1 = last_of(p.dy + reach, view->height);
    bool own = !(p.radius > 0.0) || reference_is_polygon(&p); /* covers its own pixel alone */
    if (disc->wide) {
        x0 = x1 = disc->pixel[0];
        y0 = y1 = disc->pixel[1];
    }
    for (int j = y0; j <= y1; j++)
        for (int i = x0; i <= x1; i++) {
            covering c = {.sample = &p, .depth = p.z_min};
            c.q = own ? INFINITY
                      : reference_meet(pyramid, &p, p.dx, p.dy, i + 0.5, j + 0.5, &c.depth);
            if (own)
                c.q = trunc(p.dx) == i && trunc(p.dy) == j ? 0.0 : INFINITY;
            c.end = c.depth + p.z_max - p.z_min;
            if (c.q <= 1.0 && c.depth > view->near_depth)
                each(&pixels[j * view->width + i], &c, i, j);
        }
}

static reference_pixel finish(const sums *s)
{
    reference_pixel p = s->front;
    if (!(s->total > 0.0))
        return (reference_pixel){0};
    if (is_shape(&p))
        return p;
    double extent = p.z_max - p.z_min;
    if (stp_dvec3_length(s->normal) > 0.0)
        p.normal = stp_dvec3_normalize(s->normal);
    for (int k = 0; k < 3; k++)
        p.rgb[k] = s->rgb[k] / s->total;
    p.z_min = s->depth / s->total;
    p.z_max = p.z_min + extent;
    p.dx = p.dy = 0.0;
    p.tag += 16; /* source 1: all are means */
    return p;
}

stp_status reference_splat(reference_pyramid *pyramid, const reference_disc *discs, size_t count,
                           stp_error *err)
{
    stp_status status = STP_OK;
    const stp_view *view = &pyramid->view;
    size_t pixel_count = (size_t)view->width * (size_t)view->height;
    sums *pixels = NULL;
    STP_TRY(stp_alloc(&pixels, pixel_count, sizeof *pixels, "pixels", err));
    for (size_t i = 0; i < count; i++)
        rasterise(pyramid, &discs[i], pixels, find_front);
    for (size_t i = 0; i < pixel_count; i++)
        pixels[i].total = 0.0;
    for (size_t i = 0; i < count; i++)
        rasterise(pyramid, &discs[i], pixels, add);
    for (size_t i = 0; i < pixel_count; i++)
        pyramid->levels[0].finished[i] = finish(&pixels[i]);
done:
    free(pixels);
    return status;
}
