/* Places and normals of a map's samples as a chunk codes them. */
#include "preprocess/maps/map_raster.h"

#include "formats/chunk/codec/square/plane_fit.h"
#include "formats/chunk/codec/square/square_normal.h"
#include "formats/chunk/sample/normal_grid.h"

#include <math.h>

static void to_numbers(stp_dvec3 v, double out[3])
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

stp_raster stp_map_raster(const stp_map_frame *frame, stp_dvec3 origin)
{
    double axes[3][3], at[3];
    stp_raster out = {0};
    for (int k = 0; k < 3; k++)
        to_numbers(frame->axes[k], axes[k]);
    to_numbers(stp_dvec3_sub(frame->origin, origin), at);
    for (unsigned i = 1; i < 3; i++)
        if (fabs(axes[2][i]) > fabs(axes[2][out.axis]))
            out.axis = i;
    for (unsigned k = 0; k < 2; k++) {
        const unsigned i = (out.axis + 1 + k) % 3, h = out.axis;
        double *across = out.across[k];
        across[3] = stp_raster_short(axes[2][i] / axes[2][h]);
        across[2] = stp_raster_short(frame->spacing * (axes[1][i] - across[3] * axes[1][h]));
        across[1] = stp_raster_short(frame->spacing * (axes[0][i] - across[3] * axes[0][h]));
        across[0] = (double)(float)(at[i] - across[3] * at[h]);
    }
    return out;
}

stp_dvec3 stp_map_snapped(const stp_map *map, const stp_raster *raster, uint32_t column,
                          uint32_t row, double step)
{
    double at[3], origin[3];
    const unsigned h = raster->axis;
    to_numbers(stp_map_world(map, column, row), at);
    to_numbers(map->frame.origin, origin);
    at[h] = nearbyint(at[h] / step) * step;
    for (unsigned k = 0; k < 2; k++) {
        const double *across = raster->across[k];
        const unsigned i = (h + 1 + k) % 3;
        at[i] =
            origin[i] + (column * across[1] + row * across[2] + (at[h] - origin[h]) * across[3]);
    }
    return (stp_dvec3){at[0], at[1], at[2]};
}

vec3s stp_map_normal(const stp_raster *raster, const double *heights, vec3s surface, unsigned bits)
{
    if (heights == NULL)
        return surface;
    const stp_square_normals world = {.reach = STP_MAP_NORMAL_REACH, .length = 1.0};
    const stp_square_place at = {.tilt = {raster->across[0][3], raster->across[1][3]}};
    const unsigned shift = STP_NORMAL_BITS - bits;
    const double middle = heights[STP_MAP_WINDOW * STP_MAP_WINDOW / 2];
    const int reach = STP_MAP_NORMAL_REACH;
    stp_plane_sums sums = {0};
    double slopes[2], place[2];
    int32_t uv[2];
    uint8_t code[3];
    for (int j = -reach; j <= reach; j++)
        for (int i = -reach; i <= reach; i++, heights++)
            if (!isnan(*heights))
                stp_plane_add(&sums, i, j, *heights - middle);
    if (!stp_plane_slopes(&sums, slopes))
        return surface;
    stp_square_normal_of(&world, raster, &at, slopes, place);
    if (!isfinite(place[0]) || !isfinite(place[1])) /* spacings that no float holds */
        return surface;
    for (int i = 0; i < 2; i++)
        uv[i] = stp_normal_grid_code((int32_t)floor(place[i] / (1u << shift) + 0.5), shift);
    stp_normal_codes_put(uv, code);
    return stp_normal_decode(code);
}
