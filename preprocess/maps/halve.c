/* Parts a set of points. */
#include "preprocess/maps/halve.h"

#include "preprocess/surface/moments.h"

#include <string.h>

static stp_dvec3 middle_of(const stp_cloud *cloud, const uint32_t *places, uint32_t count,
                           double *side)
{
    stp_dbox box = stp_dbox_empty();
    for (uint32_t i = 0; i < count; i++)
        stp_dbox_add(&box, cloud->points[places[i]].position);
    *side = stp_dbox_side(&box);
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t i = 0; i < count; i++)
        sum = stp_dvec3_add(sum, stp_dvec3_sub(cloud->points[places[i]].position, box.min));
    return stp_dvec3_add(box.min, stp_dvec3_scale(sum, 1.0 / count));
}

/* Lengths are divided by the box's side, so that floats hold their squares. */
static stp_dvec3 longest_axis(const stp_cloud *cloud, const uint32_t *places, uint32_t count,
                              stp_dvec3 middle, double side)
{
    stp_moments m = {{{0}}};
    for (uint32_t i = 0; i < count; i++) {
        const stp_dvec3 d =
            stp_dvec3_scale(stp_dvec3_sub(cloud->points[places[i]].position, middle), 1.0 / side);
        stp_moments_add_point(&m, stp_moments_place((float)d.x, (float)d.y, (float)d.z));
    }
    m.row[3][3] = (float)count;
    return stp_dvec3_from_float(stp_moments_longest(&m));
}

uint32_t stp_places_halve(const stp_cloud *cloud, uint32_t *places, uint32_t count,
                          uint32_t *scratch)
{
    double side = 0.0;
    const stp_dvec3 middle = middle_of(cloud, places, count, &side);
    uint32_t first = 0, second = 0;
    if (!(side > 0.0))
        return count / 2;
    const stp_dvec3 axis = longest_axis(cloud, places, count, middle, side);
    for (uint32_t i = 0; i < count; i++) {
        const stp_dvec3 d = stp_dvec3_sub(cloud->points[places[i]].position, middle);
        if (stp_dvec3_dot(d, axis) < 0.0)
            places[first++] = places[i];
        else
            scratch[second++] = places[i];
    }
    memcpy(places + first, scratch, second * sizeof *places);
    return first > 0 && second > 0 ? first : count / 2;
}
