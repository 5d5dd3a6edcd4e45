/* Compares what lies level at the low ends of y and z. */
#include "preprocess/viewpoint/up_axis.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"

#include <math.h>
#include <stdlib.h>

/* A floor has at least this share, and this many times as much as the other axis has. */
#define FLOOR_LEAST 0.15
#define FLOOR_TIMES 2.0
/* A tall thing: so many times as long as it is wide. What is longer still is a tunnel or a street.
 */
#define TALL_LEAST 1.5
#define TALL_MOST 6.0

/* A ground at the high end of y: see stp_up_is_against_y. */
#define GROUND_LEAST 0.3   /* of all columns */
#define HIGH_PART 0.1      /* of the extent along y */
#define POINTS 16384u      /* are looked at, at most */
#define ALONG_COSINE 0.9f  /* of a normal along y, or against it */
#define NORMALS_LEAST 50u  /* such normals; fewer say nothing */
#define AGAINST_LEAST 0.95 /* of them */
/* Mean of the given normals against z, and where such points lie: see stp_faces_along_z. */
#define FACING_LEAST 0.5
#define WIDEST_TANGENT 3.0
#define FARTHEST 20.0     /* m, for depth cameras; ground above the origin may be higher */
#define BEFORE_LEAST 0.99 /* of all points */

/* The share of columns that are level at the low end, less that at the high end. */
static double share_of(const stp_space *s, int axis)
{
    const int other = 3 - axis;           /* x and this axis lie across */
    const int layers = s->size[axis] - 2; /* the grid has a margin of one voxel */
    const int end = layers > 14 ? (layers + 5) / 10 : 1;
    int columns = 0, floors = 0;
    for (int i = 0; i < s->size[other]; i++)
        for (int x = 0; x < s->size[0]; x++) {
            bool any = false, low = false, high = false;
            for (int h = 0; h < s->size[axis]; h++) {
                const size_t at = axis == 1 ? stp_space_at(s, x, h, i) : stp_space_at(s, x, i, h);
                const bool level = s->count[at] > 0 && 2 * s->level[axis][at] > s->count[at];
                any = any || s->count[at] > 0;
                low = low || (level && h <= end);
                high = high || (level && s->size[axis] - 1 - h <= end);
            }
            columns += any;
            floors += low - high;
        }
    return columns > 0 ? (double)floors / columns : 0.0;
}

double stp_floor_share(const stp_space *s, int axis)
{
    return fmax(share_of(s, axis), 0.0);
}

stp_status stp_up_is_against_y(bool *out, const stp_cloud *cloud, const stp_space *s,
                               stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud_point *points = NULL;
    uint32_t count = 0, level = 0, against = 0;
    const double from = s->box.max.y - HIGH_PART * (s->box.max.y - s->box.min.y);
    *out = false;
    if (share_of(s, 1) > -GROUND_LEAST)
        return STP_OK;
    STP_TRY(stp_cloud_every(cloud, cloud->count / POINTS + 1, &points, &count, err));
    for (uint32_t i = 0; i < count; i++) {
        const stp_cloud_point *p = &points[i];
        if (p->given != STP_GIVEN_INPUT || p->position.y < from ||
            fabsf(p->normal.y) < ALONG_COSINE)
            continue;
        level++;
        against += p->normal.y < 0.0f;
    }
    *out = level >= NORMALS_LEAST && against >= AGAINST_LEAST * level;
done:
    free(points);
    return status;
}

stp_status stp_faces_along_z(bool *out, const stp_cloud *cloud, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud_point *points = NULL;
    uint32_t count = 0, before = 0;
    double sum = 0.0;
    STP_TRY(stp_cloud_every(cloud, cloud->count / POINTS + 1, &points, &count, err));
    for (uint32_t i = 0; i < count; i++) {
        const stp_dvec3 p = points[i].position;
        before += p.z <= FARTHEST && fmax(fabs(p.x), fabs(p.y)) <= WIDEST_TANGENT * p.z;
        sum += points[i].given == STP_GIVEN_INPUT ? (double)points[i].normal.z : 0.0;
    }
    *out = before >= BEFORE_LEAST * count && sum < -FACING_LEAST * count;
done:
    free(points);
    return status;
}

bool stp_up_is_z(const stp_space *s)
{
    const stp_dvec3 size = stp_dvec3_sub(s->box.max, s->box.min);
    const double wide = fmax(size.x, size.y);
    const double z = stp_floor_share(s, 2), y = stp_floor_share(s, 1);
    if (z >= FLOOR_LEAST && z >= FLOOR_TIMES * y)
        return true;
    const bool lies = y >= FLOOR_LEAST && y >= FLOOR_TIMES * z;
    return !lies && size.z >= TALL_LEAST * wide && size.z <= TALL_MOST * wide;
}
