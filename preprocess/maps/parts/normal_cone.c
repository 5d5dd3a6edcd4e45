/* The narrowest cone around normals. */
#include "preprocess/maps/parts/normal_cone.h"

#include "base/memory.h"
#include "preprocess/maps/parts/ball.h"

#include <stdlib.h>

/* A ball whose centre is this near to the middle of the sphere tells no direction. */
#define CENTRE_LEAST 1e-6

stp_normal_cone stp_normal_cone_of(const vec3s *normals, size_t count)
{
    const stp_smallest_ball ball = stp_ball_around(normals, count);
    stp_normal_cone out = {.cosine = -1.0};
    if (stp_dvec3_length(ball.centre) < CENTRE_LEAST)
        return out;
    out.axis = stp_dvec3_normalize(ball.centre);
    out.cosine = 1.0;
    for (size_t i = 0; i < count; i++)
        out.cosine = stp_min(out.cosine, stp_dvec3_dot(out.axis, stp_dvec3_from_float(normals[i])));
    return out;
}

/* A normal in the plane that touches the sphere at the axis. */
typedef struct place {
    double x, y;
    uint32_t index;
} place;

static int compare_places(const void *a, const void *b)
{
    const place *p = a, *q = b;
    if (p->x != q->x)
        return p->x < q->x ? -1 : 1;
    if (p->y != q->y)
        return p->y < q->y ? -1 : 1;
    return (p->index > q->index) - (p->index < q->index);
}

static void project(const vec3s *normals, uint32_t count, const stp_normal_cone *cone, place *out)
{
    stp_dvec3 axes[3];
    stp_dvec3_axes(axes, cone->axis);
    for (uint32_t i = 0; i < count; i++) {
        const stp_dvec3 n = stp_dvec3_from_float(normals[i]);
        const double along = stp_dvec3_dot(n, axes[2]);
        out[i] = (place){stp_dvec3_dot(n, axes[0]) / along, stp_dvec3_dot(n, axes[1]) / along, i};
    }
    qsort(out, count, sizeof *out, compare_places);
}

/* Whether the way from a over b to c turns to the left. */
static bool turns_left(const place *a, const place *b, const place *c)
{
    return (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x) > 0.0;
}

/* Walks along one side of the hull of sorted places (Andrew 1979). Returns how many corners. */
static uint32_t walk(const place *places, uint32_t count, bool back, place *corners)
{
    uint32_t n = 0;
    for (uint32_t k = 0; k < count; k++) {
        const place *p = &places[back ? count - 1 - k : k];
        while (n >= 2 && !turns_left(&corners[n - 2], &corners[n - 1], p))
            n--;
        corners[n++] = *p;
    }
    return n;
}

stp_status stp_normal_cone_corners(const vec3s *normals, uint32_t count,
                                   const stp_normal_cone *cone, vec3s **out, uint32_t *out_count,
                                   stp_error *err)
{
    stp_status status = STP_OK;
    place *places = NULL, *corners = NULL;
    vec3s *kept = NULL;
    STP_TRY(stp_alloc(&places, count, sizeof *places, "normals", err));
    STP_TRY(stp_alloc(&corners, 2 * (size_t)count, sizeof *corners, "normals", err));
    project(normals, count, cone, places);
    uint32_t n = walk(places, count, false, corners);
    n += walk(places, count, true, corners + n - 1) - 1; /* both sides share their ends */
    n = n > 1 ? n - 1 : 1;
    STP_TRY(stp_alloc(&kept, n, sizeof *kept, "normals", err));
    for (uint32_t i = 0; i < n; i++)
        kept[i] = normals[corners[i].index];
    *out = kept;
    *out_count = n;
done:
    free(places);
    free(corners);
    return status;
}
