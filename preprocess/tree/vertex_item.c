/* Patch vertices of stored chunks as items. */
#include "preprocess/tree/vertex_item.h"

#include "preprocess/patch/merged_radius.h"
#include "preprocess/patch/patch_build.h"

#include <limits.h>

/* Exponent of the lowest set bit of a finite number other than 0. */
static int lowest_bit(double value)
{
    int exponent = 0;
    int64_t mantissa = (int64_t)ldexp(frexp(value, &exponent), 53);
    return exponent - 53 + __builtin_ctzll((uint64_t)mantissa);
}

int stp_lowest_bits(stp_dvec3 p)
{
    const double at[3] = {p.x, p.y, p.z};
    int lowest = INT_MAX;
    for (int i = 0; i < 3; i++)
        if (at[i] != 0.0 && lowest_bit(at[i]) < lowest)
            lowest = lowest_bit(at[i]);
    return lowest;
}

/* The vertex's lattice: the one that follows from its spacing, or the shared one if that is coarser
 * and the radius has a code on it. But always one that the vertex lies on. */
static int lattice_of(const stp_disc *disc, double area, const stp_patch *patch, int shared)
{
    const int lowest = stp_lowest_bits(disc->centre);
    int exponent = stp_lattice_exponent(sqrt(area), disc->bound, 0.0, disc->centre);
    const int widest = disc->radius > 0.0 ? stp_floor_log2(disc->radius) : INT_MIN;
    shared = shared < widest ? shared : widest;
    exponent = exponent > patch->exponent ? exponent : patch->exponent;
    exponent = exponent > shared ? exponent : shared;
    return exponent < lowest ? exponent : lowest;
}

stp_item stp_vertex_item(const stp_placed_chunk *placed, uint32_t p, int shared)
{
    const int level = STP_LEVEL_COUNT - 1;
    const stp_patch *patch = &placed->chunk->patches[p];
    const stp_sample *sample = &placed->chunk->samples[level][p];
    stp_disc disc = stp_disc_from_sample(sample, patch);
    stp_sample middle = {
        .position = {patch->bound_centre[0], patch->bound_centre[1], patch->bound_centre[2]}};
    stp_dvec3 off = stp_dvec3_sub(stp_sample_position(&middle, patch), disc.centre);
    stp_dvec3 axis = stp_dvec3_from_float(stp_normal_decode(patch->cone_axis));
    double cosine = stp_max(-1.0, stp_min(1.0, stp_dvec3_dot(axis, disc.normal)));
    double side = disc.radius / STP_MERGED_LAMBDA;
    disc.error = stp_error_decode(patch->error[level], patch->exponent);
    disc.tangential_error = stp_error_decode(patch->tangential_error[level], patch->exponent);
    disc.colour_error = patch->colour_error[level];
    disc.low = -disc.error;
    disc.high = disc.error;
    disc.bound = stp_dvec3_length(off) + stp_radius_decode(patch->bound_radius, patch->exponent);
    disc.bound = stp_max(disc.bound, disc.radius);
    disc.reach = disc.bound;
    disc.cone = stp_min(M_PI, acos(cosine) + stp_cone_angle_decode(patch->cone_angle));
    disc.centre = stp_dvec3_add(placed->origin, disc.centre);
    return (stp_item){.disc = disc,
                      .area = side * side,
                      .exponent = lattice_of(&disc, side * side, patch, shared),
                      .intensity = sample->intensity,
                      .class_id = sample->class_id,
                      .flags = sample->flags,
                      .normal = {sample->normal[0], sample->normal[1], sample->normal[2]}};
}
