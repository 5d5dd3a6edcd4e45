/* Errors of merged samples over the discs they replace. */
#include "formats/chunk/patch_bounds.h"

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
    if (sample->flags & STP_SAMPLE_HAS_NORMAL)
        disc.normal = stp_dvec3_normalize(stp_dvec3_from_float(stp_normal_decode(sample->normal)));
    return disc;
}

static bool has_normal(const stp_disc *disc)
{
    return disc->normal.x != 0.0 || disc->normal.y != 0.0 || disc->normal.z != 0.0;
}

/* Height of x over the disc and distance by which it lies outside, in the disc's plane. */
static void offset_from(const stp_disc *disc, stp_dvec3 x, double *height, double *overhang)
{
    stp_dvec3 v = stp_dvec3_sub(x, disc->centre);
    double h = stp_dvec3_dot(v, disc->normal);
    double across = sqrt(fmax(0.0, stp_dvec3_dot(v, v) - h * h));
    *height = fabs(h);
    *overhang = fmax(0.0, across - disc->radius);
}

/* Takes the point's nearest disc into the errors. */
static void measure_point(stp_dvec3 x, const stp_disc *discs, unsigned count, stp_merge_error *out)
{
    double nearest = INFINITY;
    double error = 0.0;
    double tangential = 0.0;
    for (unsigned i = 0; i < count; i++) {
        double height = 0.0;
        double overhang = 0.0;
        offset_from(&discs[i], x, &height, &overhang);
        double distance = height * height + overhang * overhang;
        if (distance < nearest) {
            nearest = distance;
            error = height + discs[i].error;
            tangential = overhang + discs[i].tangential_error;
        }
    }
    out->error = fmax(out->error, error);
    out->tangential_error = fmax(out->tangential_error, tangential);
}

/* Takes one disc's extents along and across the merged normal, its bound, cone and colour. */
static void measure_disc(const stp_disc *merged, const stp_disc *disc, stp_merge_error *out)
{
    stp_dvec3 d = stp_dvec3_sub(disc->centre, merged->centre);
    bool known = has_normal(merged) && has_normal(disc);
    double cosine = known ? stp_dvec3_dot(disc->normal, merged->normal) : 0.0;
    double sine = sqrt(fmax(0.0, 1.0 - cosine * cosine));
    double height = stp_dvec3_dot(d, merged->normal);
    double across = sqrt(fmax(0.0, stp_dvec3_dot(d, d) - height * height));
    double thick = fmax(fabs(disc->low), fabs(disc->high));
    double tilt = disc->reach * sine;
    double up = cosine >= 0.0 ? disc->high * cosine : disc->low * cosine;
    double down = cosine >= 0.0 ? disc->low * cosine : disc->high * cosine;
    out->high = fmax(out->high, height + up + tilt);
    out->low = fmin(out->low, height + down - tilt);
    out->reach = fmax(out->reach, across + disc->reach + thick * sine);
    out->bound = fmax(out->bound, stp_dvec3_length(d) + disc->bound);
    double angle = known ? acos(fmax(-1.0, fmin(1.0, cosine))) : 0.0;
    out->cone = fmax(out->cone, angle + disc->cone);
    for (int i = 0; i < 3; i++)
        out->colour_error =
            fmax(out->colour_error, fabs(disc->rgb[i] - merged->rgb[i]) + disc->colour_error);
    out->error = fmax(out->error, disc->error);
    out->tangential_error = fmax(out->tangential_error, disc->tangential_error);
}

stp_merge_error stp_merge_measure(const stp_disc *merged, const stp_disc *discs, unsigned count)
{
    stp_merge_error out = {.low = INFINITY, .high = -INFINITY};
    for (unsigned i = 0; i < count; i++)
        measure_disc(merged, &discs[i], &out);
    out.error = fmax(out.error, out.high - out.low);
    measure_point(merged->centre, discs, count, &out);
    if (has_normal(merged) && merged->radius > 0.0) {
        stp_dvec3 u, v;
        stp_disc_axes(merged->normal, &u, &v);
        for (int i = 0; i < STP_RIM_POINTS; i++) {
            double angle = 2.0 * M_PI * (double)i / STP_RIM_POINTS;
            stp_dvec3 rim = stp_dvec3_add(stp_dvec3_scale(u, merged->radius * cos(angle)),
                                          stp_dvec3_scale(v, merged->radius * sin(angle)));
            measure_point(stp_dvec3_add(merged->centre, rim), discs, count, &out);
        }
    }
    return out;
}
