/* Discs under a merged disc, several at a time. */
#include "formats/chunk/measure/merge_lanes.h"

#include "base/wide.h"
#include "formats/chunk/codec/inline.h"
#include "formats/chunk/measure/rim.h"

#include <float.h>
#include <math.h>

#define FAR 1e30f
/* Rim points that are taken at a time. */
#define STEP 8

/* Of the discs, with those that fill up the last step. */
static inline unsigned filled(unsigned count)
{
    return (count + STP_MERGED_STEP - 1) & ~(STP_MERGED_STEP - 1);
}

/* How a disc lies to the merged disc: cosine and sine of the angle of their normals, the height of
 * its centre, and the least and the greatest height of its originals. */
typedef struct lying {
    double cosine, sine, height, low, high;
} lying;

STP_INLINE lying lie(const stp_merge_lanes *discs, unsigned i, stp_dvec3 normal)
{
    const double x = discs->centre[0][i], y = discs->centre[1][i], z = discs->centre[2][i];
    const double nx = discs->normal[0][i], ny = discs->normal[1][i], nz = discs->normal[2][i];
    const double c = nx * normal.x + ny * normal.y + nz * normal.z;
    const double sine = sqrt(stp_max(0.0, 1.0 - c * c));
    const double height = x * normal.x + y * normal.y + z * normal.z;
    const double lowest = discs->low[i], highest = discs->high[i], tilt = discs->reach[i] * sine;
    const double up = (c >= 0.0 ? highest : lowest) * c;
    const double down = (c >= 0.0 ? lowest : highest) * c;
    return (lying){c, sine, height, height + down - tilt, height + up + tilt};
}

STP_WIDE
stp_merge_extent stp_merge_lanes_extent(const stp_merge_lanes *discs, stp_dvec3 normal)
{
    const unsigned count = filled(discs->count);
    double low = DBL_MAX, high = -DBL_MAX, most = 0.0, bound = 0.0, cosine = 1.0;
    for (unsigned i = 0; i < count; i++) {
        const double x = discs->centre[0][i], y = discs->centre[1][i], z = discs->centre[2][i];
        const double nx = discs->normal[0][i], ny = discs->normal[1][i], nz = discs->normal[2][i];
        const lying d = lie(discs, i, normal);
        const double squared = x * x + y * y + z * z;
        const double across = sqrt(stp_max(0.0, squared - d.height * d.height));
        const double thick = stp_max(fabs(discs->low[i]), fabs(discs->high[i]));
        const bool known = nx * nx + ny * ny + nz * nz > 0.5;
        cosine = stp_min(cosine, known ? d.cosine : 1.0);
        high = stp_max(high, d.high);
        low = stp_min(low, d.low);
        most = stp_max(most, across + discs->reach[i] + thick * d.sine);
        bound = stp_max(bound, sqrt(squared) + discs->bound[i]);
    }
    return (stp_merge_extent){low, high, most, bound, cosine};
}

STP_WIDE
stp_merge_heights stp_merge_lanes_heights(const stp_merge_lanes *discs, stp_dvec3 normal,
                                          double radius)
{
    const unsigned count = filled(discs->count);
    double low = DBL_MAX, high = -DBL_MAX, off = 0.0;
    for (unsigned i = 0; i < count; i++) {
        const double x = discs->centre[0][i], y = discs->centre[1][i], z = discs->centre[2][i];
        const double nx = discs->normal[0][i], ny = discs->normal[1][i], nz = discs->normal[2][i];
        const lying d = lie(discs, i, normal);
        high = stp_max(high, d.high);
        low = stp_min(low, d.low);
        off = stp_max(off, fabs(x * nx + y * ny + z * nz) + radius * d.sine);
    }
    return (stp_merge_heights){low, high, off};
}

/* The discs by the merged disc's radius, as floats. */
typedef struct near_discs {
    unsigned count, filled;
    float x[STP_MERGED_MOST], y[STP_MERGED_MOST], z[STP_MERGED_MOST];
    float nx[STP_MERGED_MOST], ny[STP_MERGED_MOST], nz[STP_MERGED_MOST];
    float radius[STP_MERGED_MOST];
} near_discs;

static inline void scale_discs(const stp_merge_lanes *discs, double scale, near_discs *out)
{
    out->count = discs->count;
    out->filled = filled(discs->count);
    for (unsigned i = 0; i < out->filled; i++) {
        out->x[i] = (float)(discs->centre[0][i] * scale);
        out->y[i] = (float)(discs->centre[1][i] * scale);
        out->z[i] = (float)(discs->centre[2][i] * scale);
        out->nx[i] = (float)discs->normal[0][i];
        out->ny[i] = (float)discs->normal[1][i];
        out->nz[i] = (float)discs->normal[2][i];
        out->radius[i] = (float)(discs->radius[i] * scale);
    }
}

/* The squared distance of a point from disc i, and its height over the disc's plane. */
static inline float squared_from(const near_discs *d, unsigned i, float x, float y, float z,
                                 float *height)
{
    x -= d->x[i];
    y -= d->y[i];
    z -= d->z[i];
    const float h = x * d->nx[i] + y * d->ny[i] + z * d->nz[i];
    const float across = x * x + y * y + z * z - h * h;
    const float overhang = fmaxf(sqrtf(fmaxf(across, 0.0f)) - d->radius[i], 0.0f);
    *height = fabsf(h);
    return h * h + overhang * overhang;
}

/* Of the centre, over all discs at a time. */
static inline void take_centre(const near_discs *d, stp_merged_points *out)
{
    float squared[STP_MERGED_MOST], height[STP_MERGED_MOST], least = FAR;
    for (unsigned i = 0; i < d->filled; i++) {
        squared[i] = squared_from(d, i, 0.0f, 0.0f, 0.0f, &height[i]);
        least = fminf(least, squared[i]);
    }
    out->nearest[0] = 0;
    out->height[0] = FAR;
    for (unsigned i = d->count; i-- > 0;)
        // cppcheck-suppress uninitvar ; all that are filled have been set, and these are more
        if (squared[i] == least) {
            out->nearest[0] = i;
            out->height[0] = height[i];
        }
}

/* Of STEP rim points from the first on, over one disc after the other. */
static inline void take_rim(const near_discs *d, const float at[3][STP_RIM_POINTS], unsigned first,
                            stp_merged_points *out)
{
    float x[STEP], y[STEP], z[STEP], squared[STEP], height[STEP];
    uint32_t nearest[STEP];
    for (unsigned k = 0; k < STEP; k++) {
        x[k] = at[0][first + k];
        y[k] = at[1][first + k];
        z[k] = at[2][first + k];
        squared[k] = height[k] = FAR;
        nearest[k] = 0;
    }
    for (unsigned i = 0; i < d->count; i++)
        for (unsigned k = 0; k < STEP; k++) {
            float h;
            const float s = squared_from(d, i, x[k], y[k], z[k], &h);
            const bool nearer = s < squared[k];
            nearest[k] = nearer ? i : nearest[k];
            height[k] = nearer ? h : height[k];
            squared[k] = nearer ? s : squared[k];
        }
    for (unsigned k = 0; k < STEP; k++) {
        out->nearest[1 + first + k] = nearest[k];
        out->height[1 + first + k] = height[k];
    }
}

STP_WIDE
void stp_merge_lanes_nearest(const stp_merge_lanes *discs, stp_dvec3 centre,
                             const stp_dvec3 axes[2], double radius, stp_merged_points *out)
{
    const double scale = radius > 0.0 ? 1.0 / radius : 1.0;
    const double middle[3] = {centre.x, centre.y, centre.z};
    near_discs near;
    float at[3][STP_RIM_POINTS];
    scale_discs(discs, scale, &near);
    for (int a = 0; a < 3; a++)
        out->at[a][0] = middle[a];
    take_centre(&near, out);
    if (!axes)
        return;
    const double u[3] = {axes[0].x, axes[0].y, axes[0].z};
    const double v[3] = {axes[1].x, axes[1].y, axes[1].z};
    for (int a = 0; a < 3; a++)
        for (unsigned i = 0; i < STP_RIM_POINTS; i++) {
            const double rim = u[a] * (radius * stp_rim[0][i]) + v[a] * (radius * stp_rim[1][i]);
            out->at[a][1 + i] = middle[a] + rim;
            at[a][i] = (float)((out->at[a][1 + i] - middle[a]) * scale);
        }
    for (unsigned first = 0; first < STP_RIM_POINTS; first += STEP)
        take_rim(&near, at, first, out);
}
