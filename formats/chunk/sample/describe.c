/* What an entry says of patches. */
#include "formats/chunk/sample/describe.h"

#include <math.h>

float stp_round_up(double value)
{
    float rounded = (float)value;
    return (double)rounded < value ? nextafterf(rounded, INFINITY) : rounded;
}

float stp_round_down(double value)
{
    return -stp_round_up(-value);
}

static float greater(float a, double b)
{
    return fmaxf(a, stp_round_up(b));
}

static void widen_box(stp_chunk_entry *entry, const stp_patch *patch)
{
    stp_sample centre = {
        .position = {patch->bound_centre[0], patch->bound_centre[1], patch->bound_centre[2]}};
    stp_dvec3 p = stp_sample_position(&centre, patch);
    double r = stp_radius_decode(patch->bound_radius, patch->exponent);
    const double low[3] = {p.x - r, p.y - r, p.z - r};
    const double high[3] = {p.x + r, p.y + r, p.z + r};
    for (int i = 0; i < 3; i++) {
        entry->box_min.raw[i] = fminf(entry->box_min.raw[i], stp_round_down(low[i]));
        entry->box_max.raw[i] = fmaxf(entry->box_max.raw[i], stp_round_up(high[i]));
    }
}

static void widen_errors(stp_chunk_entry *entry, const stp_patch *patch)
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        entry->error[l] =
            greater(entry->error[l], stp_error_decode(patch->error[l], patch->exponent));
        entry->tangential_error[l] =
            greater(entry->tangential_error[l],
                    stp_error_decode(patch->tangential_error[l], patch->exponent));
        entry->colour_error[l] = fmaxf(entry->colour_error[l], (float)patch->colour_error[l]);
    }
}

/* The cone: around the mean of the patches' axes, wide enough for all their cones. */
static void find_cone(const stp_patch *patches, uint32_t count, stp_chunk_entry *entry)
{
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    double angle = 0.0;
    for (uint32_t i = 0; i < count; i++)
        sum = stp_dvec3_add(sum, stp_dvec3_from_float(stp_normal_decode(patches[i].cone_axis)));
    sum = stp_dvec3_normalize(sum);
    entry->cone_axis = stp_dvec3_to_float(sum);
    stp_dvec3 axis = stp_dvec3_normalize(stp_dvec3_from_float(entry->cone_axis));
    for (uint32_t i = 0; i < count; i++) {
        const stp_patch *patch = &patches[i];
        stp_dvec3 other =
            stp_dvec3_normalize(stp_dvec3_from_float(stp_normal_decode(patch->cone_axis)));
        double off =
            atan2(stp_dvec3_length(stp_dvec3_cross(axis, other)), stp_dvec3_dot(axis, other));
        angle = fmax(angle, off + stp_cone_angle_decode(patch->cone_angle));
    }
    if (stp_dvec3_length(sum) == 0.0) {
        entry->cone_axis = (vec3s){{0.0f, 0.0f, 1.0f}};
        angle = M_PI;
    }
    /* A float axis is a unit vector to 1e-7; the margin covers that and decoding in float. */
    entry->cone_angle = stp_round_up(fmin(angle + 1e-6, M_PI));
}

void stp_patches_describe(const stp_patch *patches, uint32_t count, stp_chunk_entry *entry)
{
    unsigned closed = STP_PATCH_CLOSED;
    entry->patch_count = count;
    entry->flags = 0;
    entry->box_min = (vec3s){{INFINITY, INFINITY, INFINITY}};
    entry->box_max = (vec3s){{-INFINITY, -INFINITY, -INFINITY}};
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        entry->error[l] = entry->tangential_error[l] = entry->colour_error[l] = 0.0f;
    for (uint32_t i = 0; i < count; i++) {
        widen_box(entry, &patches[i]);
        widen_errors(entry, &patches[i]);
        entry->flags |= patches[i].flags & STP_PATCH_TWO_SIDED;
        closed &= patches[i].flags;
    }
    entry->flags |= closed ? STP_CHUNK_CLOSED : 0;
    find_cone(patches, count, entry);
}
