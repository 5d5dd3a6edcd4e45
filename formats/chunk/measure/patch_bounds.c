/* Errors of merged samples over the discs they replace. */
#include "formats/chunk/measure/patch_bounds.h"

#include "formats/chunk/measure/disc_lanes.h"

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

/* Widens extents along and across the merged normal, the bound and the cone by one disc. If the
 * disc stands for itself alone, only notes its cosine in *least_cosine. */
static void measure_disc(const stp_disc *merged, const stp_disc *disc, stp_merge_error *out,
                         double *least_cosine)
{
    stp_dvec3 d = stp_dvec3_sub(disc->centre, merged->centre);
    bool known = has_normal(merged) && has_normal(disc);
    double cosine = known ? stp_dvec3_dot(disc->normal, merged->normal) : 0.0;
    double sine = sqrt(stp_max(0.0, 1.0 - cosine * cosine));
    double height = stp_dvec3_dot(d, merged->normal);
    double across = sqrt(stp_max(0.0, stp_dvec3_dot(d, d) - height * height));
    double thick = stp_max(fabs(disc->low), fabs(disc->high));
    double tilt = disc->reach * sine;
    double up = cosine >= 0.0 ? disc->high * cosine : disc->low * cosine;
    double down = cosine >= 0.0 ? disc->low * cosine : disc->high * cosine;
    out->high = stp_max(out->high, height + up + tilt);
    out->low = stp_min(out->low, height + down - tilt);
    out->reach = stp_max(out->reach, across + disc->reach + thick * sine);
    out->bound = stp_max(out->bound, stp_dvec3_length(d) + disc->bound);
    if (disc->cone > 0.0)
        measure_cone(known ? cosine : 1.0, disc->cone, out);
    else
        *least_cosine = stp_min(*least_cosine, known ? cosine : 1.0);
    out->error = stp_max(out->error, disc->error);
}

#define COS_1 0.92387953251128674 /* of an eighth of pi */
#define SIN_1 0.38268343236508977
#define COS_2 0.70710678118654752 /* of a quarter of pi */

static const double rim_points[STP_RIM_POINTS][2] = {
    {1.0, 0.0},  {COS_1, SIN_1},   {COS_2, COS_2},   {SIN_1, COS_1},
    {0.0, 1.0},  {-SIN_1, COS_1},  {-COS_2, COS_2},  {-COS_1, SIN_1},
    {-1.0, 0.0}, {-COS_1, -SIN_1}, {-COS_2, -COS_2}, {-SIN_1, -COS_1},
    {0.0, -1.0}, {SIN_1, -COS_1},  {COS_2, -COS_2},  {COS_1, -SIN_1}};

unsigned stp_disc_points(const stp_disc *disc, stp_dvec3 out[STP_DISC_POINTS])
{
    stp_dvec3 u, v;
    out[0] = disc->centre;
    if (!has_normal(disc) || !(disc->radius > 0.0))
        return 1;
    stp_disc_axes(disc->normal, &u, &v);
    for (int i = 0; i < STP_RIM_POINTS; i++) {
        stp_dvec3 rim = stp_dvec3_add(stp_dvec3_scale(u, disc->radius * rim_points[i][0]),
                                      stp_dvec3_scale(v, disc->radius * rim_points[i][1]));
        out[i + 1] = stp_dvec3_add(disc->centre, rim);
    }
    return STP_DISC_POINTS;
}

/* Lanes tell heights to this part of the merged disc's radius. */
#define HEIGHT_SLACK 0x1p-16

/* The greatest height of the merged disc's points over their nearest discs, with the errors of
 * these. Heights in lanes tell which of them it may be. */
static double measure_heights(const stp_disc *merged, const stp_disc *discs, unsigned count)
{
    const bool round = has_normal(merged) && merged->radius > 0.0;
    const double unit = merged->radius > 0.0 ? merged->radius : 1.0;
    stp_dvec3 axes[2] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    stp_disc_lanes lanes;
    double greatest = 0.0;
    if (round)
        stp_disc_axes(merged->normal, &axes[0], &axes[1]);
    stp_disc_lanes_begin(&lanes, merged->centre, axes, merged->radius);
    for (unsigned i = 0; i < count; i++)
        stp_disc_lanes_try(&lanes, discs[i].centre, discs[i].normal, discs[i].radius, i);
    for (unsigned i = 0; i < (round ? STP_DISC_POINTS : 1); i++) {
        const stp_disc *disc = &discs[lanes.nearest[i]];
        const stp_dvec3 point = {lanes.at[0][i], lanes.at[1][i], lanes.at[2][i]};
        const double told = (double)lanes.height[i] * (1.0 + HEIGHT_SLACK) + HEIGHT_SLACK;
        if (told * unit + disc->error <= greatest)
            continue;
        double height = fabs(stp_dvec3_dot(stp_dvec3_sub(point, disc->centre), disc->normal));
        greatest = stp_max(greatest, height + disc->error);
    }
    return greatest;
}

stp_merge_error stp_merge_measure(const stp_disc *merged, const stp_disc *discs, unsigned count)
{
    stp_merge_error out = {.low = INFINITY, .high = -INFINITY};
    double least_cosine = 1.0;
    for (unsigned i = 0; i < count; i++)
        measure_disc(merged, &discs[i], &out, &least_cosine);
    measure_cone(least_cosine, 0.0, &out);
    out.error = stp_max(out.error, measure_heights(merged, discs, count));
    const double side = stp_max(out.high, -out.low);
    out.least_error = stp_max(out.error, stp_min(side, out.high - out.low));
    out.error = stp_max(out.error, side);
    return out;
}

double stp_colour_variation(const stp_disc *merged, const stp_disc *finest,
                            const uint8_t counts[STP_LEVEL_COUNT], int level)
{
    double squares[3] = {0.0, 0.0, 0.0};
    for (unsigned j = 0; j < counts[level]; j++) {
        unsigned end = stp_covered_begin(counts, level, j + 1, 0);
        for (unsigned i = stp_covered_begin(counts, level, j, 0); i < end; i++)
            for (int c = 0; c < 3; c++) {
                double apart = finest[i].rgb[c] - merged[j].rgb[c], own = finest[i].colour_error;
                squares[c] += apart * apart + own * own;
            }
    }
    return sqrt(stp_max(squares[0], stp_max(squares[1], squares[2])) / counts[0]);
}
