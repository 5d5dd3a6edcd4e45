/* Positions on the world's own lattices. */
#include "preprocess/patch/world_lattice.h"

#include "preprocess/patch/patch_build.h"

static double farthest_of(const stp_dbox *box)
{
    const double at[6] = {box->min.x, box->min.y, box->min.z, box->max.x, box->max.y, box->max.z};
    double far = 0.0;
    for (int i = 0; i < 6; i++)
        far = stp_max(far, fabs(at[i]));
    return far;
}

static int greater(int a, int b)
{
    return a > b ? a : b;
}

stp_lattices stp_lattices_choose(int exponent, const stp_dbox *box, double radius, double side)
{
    const double far = farthest_of(box);
    if (far > 0.0)
        exponent = greater(exponent, stp_floor_log2(far) - STP_WORLD_OCTAVES);
    int vertex = radius > 0.0 ? stp_floor_log2(radius / STP_VERTEX_PARTS) : exponent;
    if (side > 0.0)
        vertex = greater(vertex, stp_floor_log2(side) - STP_MODEL_OCTAVES);
    exponent = greater(exponent, vertex - STP_VERTEX_OCTAVES);
    return (stp_lattices){exponent, greater(vertex, exponent)};
}

stp_dvec3 stp_on_lattice(stp_dvec3 p, int exponent)
{
    const double in = ldexp(1.0, -exponent), out = ldexp(1.0, exponent);
    return (stp_dvec3){stp_nearest_whole(p.x * in) * out, stp_nearest_whole(p.y * in) * out,
                       stp_nearest_whole(p.z * in) * out};
}

bool stp_world_place(stp_patch *patch, const stp_dbox *box, int exponent, int coarsest,
                     stp_dvec3 chunk_origin)
{
    const double step = ldexp(1.0, exponent), margin = ldexp(1.0, coarsest);
    const stp_dvec3 low = stp_dvec3_sub(box->min, chunk_origin);
    const stp_dvec3 high = stp_dvec3_sub(box->max, chunk_origin);
    const double from[3] = {low.x, low.y, low.z}, to[3] = {high.x, high.y, high.z};
    patch->exponent = (int16_t)exponent;
    for (int axis = 0; axis < 3; axis++) {
        const double least = from[axis] - margin, most = to[axis] + margin;
        if (!(most - least <= STP_POSITION_STEPS * step) || fabs(least) > STP_ORIGIN_STEPS * step ||
            fabs(most) > STP_ORIGIN_STEPS * step)
            return false;
        patch->origin[axis] = (int32_t)floor(least / step);
    }
    return true;
}

void stp_world_store(const stp_patch *patch, stp_dvec3 chunk_origin, stp_dvec3 p, stp_sample *out)
{
    const stp_dvec3 own = stp_dvec3_sub(p, chunk_origin);
    const double v[3] = {own.x, own.y, own.z}, in = ldexp(1.0, -patch->exponent);
    for (int axis = 0; axis < 3; axis++)
        out->position[axis] = (uint16_t)(v[axis] * in - (double)patch->origin[axis]);
}
