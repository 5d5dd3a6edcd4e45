/* Points in lanes against one disc after the other. */
#include "formats/chunk/disc_lanes.h"

#include <math.h>
#include <stdbool.h>

#define FAR 1e30f

void stp_disc_lanes_begin(stp_disc_lanes *out, const stp_dvec3 *points, unsigned count,
                          stp_dvec3 origin, double unit, uint32_t first)
{
    out->origin = origin;
    out->scale = unit > 0.0 ? 1.0 / unit : 1.0;
    for (unsigned i = 0; i < STP_DISC_LANES; i++) {
        stp_dvec3 p = points[i < count ? i : 0];
        p = stp_dvec3_scale(stp_dvec3_sub(p, origin), out->scale);
        out->x[i] = (float)p.x;
        out->y[i] = (float)p.y;
        out->z[i] = (float)p.z;
        out->squared[i] = FAR;
        out->nearest[i] = first;
    }
}

void stp_disc_lanes_try(stp_disc_lanes *lanes, stp_dvec3 centre, stp_dvec3 normal, double radius,
                        uint32_t index)
{
    stp_dvec3 c = stp_dvec3_scale(stp_dvec3_sub(centre, lanes->origin), lanes->scale);
    const float cx = (float)c.x, cy = (float)c.y, cz = (float)c.z;
    const float nx = (float)normal.x, ny = (float)normal.y, nz = (float)normal.z;
    const float r = (float)(radius * lanes->scale);
    float squared[STP_DISC_LANES];
    for (unsigned i = 0; i < STP_DISC_LANES; i++) {
        float x = lanes->x[i] - cx, y = lanes->y[i] - cy, z = lanes->z[i] - cz;
        float height = x * nx + y * ny + z * nz;
        float across = x * x + y * y + z * z - height * height;
        float overhang = sqrtf(fmaxf(across, 0.0f)) - r;
        overhang = fmaxf(overhang, 0.0f);
        squared[i] = height * height + overhang * overhang;
    }
    for (unsigned i = 0; i < STP_DISC_LANES; i++) {
        bool nearer = squared[i] < lanes->squared[i];
        lanes->nearest[i] = nearer ? index : lanes->nearest[i];
        lanes->squared[i] = nearer ? squared[i] : lanes->squared[i];
    }
}
