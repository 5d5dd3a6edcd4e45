/* Errors of merged samples over the discs they replace. */
#include "formats/chunk/measure/patch_bounds.h"

#include "base/wide.h"
#include "formats/chunk/measure/merge_lanes.h"

#include <assert.h>
#include <stddef.h>

void stp_disc_axes(stp_dvec3 n, stp_dvec3 *u, stp_dvec3 *v)
{
    double sign = copysign(1.0, n.z);
    double a = -1.0 / (sign + n.z);
    double b = n.x * n.y * a;
    *u = (stp_dvec3){1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x};
    *v = (stp_dvec3){b, sign + n.y * n.y * a, -n.y};
}

stp_disc stp_disc_from_sample(const stp_sample *sample, const stp_patch *patch)
{
    double radius = stp_sample_radius(sample, patch);
    stp_disc disc = {.centre = stp_sample_position(sample, patch),
                     .radius = radius,
                     .rgb = {sample->rgb[0], sample->rgb[1], sample->rgb[2]},
                     .reach = radius,
                     .bound = radius};
    if (stp_sample_is_flat(sample))
        disc.normal = stp_dvec3_normalize(stp_dvec3_from_float(stp_normal_decode(sample->normal)));
    return disc;
}

static bool has_normal(const stp_disc *disc)
{
    return disc->normal.x != 0.0 || disc->normal.y != 0.0 || disc->normal.z != 0.0;
}

/* Widens the cone by a normal with this cosine to the axis. Saves the arc cosine if the angle is
 * surely inside already: 1 - cos x > 0.45 x^2 up to one radian. */
static void measure_cone(double cosine, double own, stp_merge_error *out)
{
    double room = stp_min(out->cone - own, 1.0);
    if (room > 0.0 && 1.0 - cosine < 0.45 * room * room)
        return;
    out->cone = stp_max(out->cone, acos(stp_max(-1.0, stp_min(1.0, cosine))) + own);
}

static void fill_lane(const stp_disc *merged, const stp_disc *disc, unsigned i,
                      stp_merge_lanes *lanes)
{
    const stp_dvec3 d = stp_dvec3_sub(disc->centre, merged->centre);
    lanes->centre[0][i] = d.x;
    lanes->centre[1][i] = d.y;
    lanes->centre[2][i] = d.z;
    lanes->normal[0][i] = disc->normal.x;
    lanes->normal[1][i] = disc->normal.y;
    lanes->normal[2][i] = disc->normal.z;
    lanes->radius[i] = disc->radius;
    lanes->low[i] = disc->low;
    lanes->high[i] = disc->high;
    lanes->reach[i] = disc->reach;
    lanes->bound[i] = disc->bound;
}

/* The discs in lanes. */
static void fill_lanes(const stp_disc *merged, const stp_disc *discs, unsigned count,
                       stp_merge_lanes *lanes)
{
    lanes->count = count;
    for (unsigned i = 0; i < count; i++)
        fill_lane(merged, &discs[i], i, lanes);
    for (unsigned i = count; i % STP_MERGED_STEP > 0; i++)
        fill_lane(merged, &discs[0], i, lanes);
}

/* The error and the cone of what the discs stand for themselves. cosine: stp_merge_extent's. */
static void measure_carried(const stp_disc *merged, const stp_disc *discs, unsigned count,
                            double cosine, stp_merge_error *out)
{
    const bool known = has_normal(merged);
    double least = known ? cosine : 1.0, cone = 0.0;
    for (unsigned i = 0; i < count; i++) {
        out->error = stp_max(out->error, discs[i].error);
        cone = stp_max(cone, discs[i].cone);
    }
    if (cone > 0.0)
        least = 1.0;
    for (unsigned i = 0; cone > 0.0 && i < count; i++) {
        const double own =
            known && has_normal(&discs[i]) ? stp_dvec3_dot(discs[i].normal, merged->normal) : 1.0;
        if (discs[i].cone > 0.0)
            measure_cone(own, discs[i].cone, out);
        else
            least = stp_min(least, own);
    }
    measure_cone(least, 0.0, out);
}

unsigned stp_disc_points(const stp_disc *disc, stp_dvec3 out[STP_DISC_POINTS])
{
    stp_dvec3 u, v;
    out[0] = disc->centre;
    if (!has_normal(disc) || !(disc->radius > 0.0))
        return 1;
    stp_disc_axes(disc->normal, &u, &v);
    for (int i = 0; i < STP_RIM_POINTS; i++) {
        stp_dvec3 rim = stp_dvec3_add(stp_dvec3_scale(u, disc->radius * stp_rim[0][i]),
                                      stp_dvec3_scale(v, disc->radius * stp_rim[1][i]));
        out[i + 1] = stp_dvec3_add(disc->centre, rim);
    }
    return STP_DISC_POINTS;
}

/* Lanes tell heights to this part of the merged disc's radius. */
#define HEIGHT_SLACK 0x1p-16

/* The greatest height of the merged disc's points over their nearest discs, with the errors of
 * these; `least`, if that is more. Heights in lanes tell which of them it may be. */
static double measure_heights(const stp_disc *merged, const stp_disc *discs,
                              const stp_merge_lanes *lanes, double least)
{
    const bool round = has_normal(merged) && merged->radius > 0.0;
    const double unit = merged->radius > 0.0 ? merged->radius : 1.0;
    stp_dvec3 axes[2];
    stp_merged_points points;
    double greatest = least;
    if (round)
        stp_disc_axes(merged->normal, &axes[0], &axes[1]);
    stp_merge_lanes_nearest(lanes, merged->centre, round ? axes : NULL, merged->radius, &points);
    for (unsigned i = 0; i < (round ? STP_DISC_POINTS : 1); i++) {
        const stp_disc *disc = &discs[points.nearest[i]];
        const stp_dvec3 point = {points.at[0][i], points.at[1][i], points.at[2][i]};
        const double told = (double)points.height[i] * (1.0 + HEIGHT_SLACK) + HEIGHT_SLACK;
        if (told * unit + disc->error <= greatest)
            continue;
        double height = fabs(stp_dvec3_dot(stp_dvec3_sub(point, disc->centre), disc->normal));
        greatest = stp_max(greatest, height + disc->error);
    }
    return greatest;
}

stp_merge_error stp_merge_measure(const stp_disc *merged, const stp_disc *discs, unsigned count)
{
    stp_merge_error out = {0};
    stp_merge_lanes lanes;
    assert(count > 0 && count <= STP_MERGED_MOST);
    fill_lanes(merged, discs, count, &lanes);
    const stp_merge_extent extent = stp_merge_lanes_extent(&lanes, merged->normal);
    measure_carried(merged, discs, count, extent.cosine, &out);
    const double side = stp_max(extent.high, -extent.low);
    const double least = stp_max(out.error, stp_min(side, extent.high - extent.low));
    out.low = extent.low;
    out.high = extent.high;
    out.reach = extent.reach;
    out.bound = extent.bound;
    out.least_error = measure_heights(merged, discs, &lanes, least);
    out.error = stp_max(out.least_error, side);
    return out;
}

stp_error_bounds stp_merge_bound_error(const stp_disc *merged, const stp_disc *discs,
                                       unsigned count)
{
    stp_merge_lanes lanes;
    double carried = 0.0;
    assert(count > 0 && count <= STP_MERGED_MOST);
    fill_lanes(merged, discs, count, &lanes);
    for (unsigned i = 0; i < count; i++)
        carried = stp_max(carried, discs[i].error);
    const stp_merge_heights h = stp_merge_lanes_heights(&lanes, merged->normal, merged->radius);
    const double low = stp_max(carried, stp_max(h.high, -h.low));
    return (stp_error_bounds){low, stp_max(low, h.off + carried)};
}

double stp_merge_measure_rim(const stp_disc *merged, const stp_disc *discs, unsigned count,
                             double least)
{
    stp_merge_lanes lanes;
    assert(count > 0 && count <= STP_MERGED_MOST);
    fill_lanes(merged, discs, count, &lanes);
    return measure_heights(merged, discs, &lanes, least);
}

/* Red, green and blue; and one more number, ignored. */
typedef double colour_lanes __attribute__((vector_size(32), aligned(8), may_alias));
_Static_assert(offsetof(stp_disc, rgb) + sizeof(colour_lanes) <= sizeof(stp_disc),
               "a number follows the colours");

STP_WIDE
double stp_colour_variation(const stp_disc *merged, const stp_disc *finest,
                            const uint8_t counts[STP_LEVEL_COUNT], int level)
{
    colour_lanes squares = {0.0, 0.0, 0.0, 0.0};
    for (unsigned j = 0; j < counts[level]; j++) {
        const colour_lanes mean = *(const colour_lanes *)merged[j].rgb;
        unsigned end = stp_covered_begin(counts, level, j + 1, 0);
        for (unsigned i = stp_covered_begin(counts, level, j, 0); i < end; i++) {
            const colour_lanes apart = *(const colour_lanes *)finest[i].rgb - mean;
            squares += apart * apart + finest[i].colour_error * finest[i].colour_error;
        }
    }
    return sqrt(stp_max(squares[0], stp_max(squares[1], squares[2])) / counts[0]);
}
