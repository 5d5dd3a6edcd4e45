/* Points in lanes against one disc after the other, and discs against one point. */
#include "formats/chunk/disc_lanes.h"

#include "base/memory.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#define FAR 1e30f
#define STEP 8u /* discs at a time */

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

stp_status stp_disc_columns_create(stp_disc_columns *out, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    *out = (stp_disc_columns){{0}};
    for (int i = 0; i < STP_DISC_COLUMNS; i++)
        STP_TRY(stp_alloc(&out->of[i], (size_t)count + STEP, sizeof **out->of, "discs", err));
done:
    return status;
}

void stp_disc_columns_clear(stp_disc_columns *columns)
{
    for (int i = 0; i < STP_DISC_COLUMNS; i++)
        free(columns->of[i]);
    *columns = (stp_disc_columns){{0}};
}

/* Squared distances of STEP discs from a point. */
static void step(const stp_disc_columns *columns, uint32_t first, const float point[3],
                 float squared[STEP])
{
    const float *cx = columns->of[0] + first, *cy = columns->of[1] + first;
    const float *cz = columns->of[2] + first, *nx = columns->of[3] + first;
    const float *ny = columns->of[4] + first, *nz = columns->of[5] + first;
    const float *radius = columns->of[6] + first;
    const float px = point[0], py = point[1], pz = point[2];
    for (unsigned i = 0; i < STEP; i++) {
        float x = px - cx[i], y = py - cy[i], z = pz - cz[i];
        float height = x * nx[i] + y * ny[i] + z * nz[i];
        float across = x * x + y * y + z * z - height * height;
        float overhang = fmaxf(sqrtf(fmaxf(across, 0.0f)) - radius[i], 0.0f);
        squared[i] = height * height + overhang * overhang;
    }
}

uint32_t stp_disc_columns_nearest(const stp_disc_columns *columns, uint32_t begin, uint32_t count,
                                  const float point[3], float *squared)
{
    uint32_t nearest = UINT32_MAX;
    float best = *squared;
    for (uint32_t at = 0; at < count; at += STEP) {
        float found[STEP];
        step(columns, begin + at, point, found);
        for (uint32_t i = 0; i < STEP && at + i < count; i++)
            if (found[i] < best) {
                best = found[i];
                nearest = begin + at + i;
            }
    }
    *squared = best;
    return nearest;
}
