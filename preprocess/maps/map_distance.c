/* How far a point is from the surface of a map. */
#include "preprocess/maps/map_distance.h"

static double to_segment(stp_dvec3 p, stp_dvec3 a, stp_dvec3 b)
{
    const stp_dvec3 way = stp_dvec3_sub(b, a), d = stp_dvec3_sub(p, a);
    const double along = stp_dvec3_dot(d, way) / stp_dvec3_dot(way, way);
    const double share = stp_min(stp_max(along, 0.0), 1.0);
    return stp_dvec3_length(stp_dvec3_sub(d, stp_dvec3_scale(way, share)));
}

double stp_triangle_distance(stp_dvec3 p, const stp_dvec3 corners[3])
{
    const stp_dvec3 n = stp_dvec3_cross(stp_dvec3_sub(corners[1], corners[0]),
                                        stp_dvec3_sub(corners[2], corners[0]));
    double least = INFINITY;
    for (int i = 0; i < 3; i++) {
        const stp_dvec3 a = corners[i], b = corners[(i + 1) % 3];
        const stp_dvec3 out = stp_dvec3_cross(stp_dvec3_sub(b, a), n);
        if (stp_dvec3_dot(out, stp_dvec3_sub(p, a)) > 0.0)
            least = stp_min(least, to_segment(p, a, b));
    }
    if (least < INFINITY) /* beside the triangle, so one of the sides it is beyond is nearest */
        return least;
    return fabs(stp_dvec3_dot(n, stp_dvec3_sub(p, corners[0]))) / stp_dvec3_length(n);
}

/* The distance to a square's triangles. These have areas, since their corners stand over different
 * places of the grid. */
static double to_square(const stp_map *map, uint32_t column, uint32_t row, stp_dvec3 p)
{
    static const uint32_t right[4] = {0, 1, 1, 0}, down[4] = {0, 0, 1, 1};
    stp_dvec3 at[4];
    unsigned missing = 4, count = 0;
    for (unsigned k = 0; k < 4; k++) {
        at[k] = stp_map_local(map, column + right[k], row + down[k]);
        if (stp_map_at(map, column + right[k], row + down[k])->flags & STP_MAP_SUPPORTED)
            count++;
        else
            missing = k;
    }
    if (count < 3)
        return INFINITY;
    const stp_dvec3 first[3] = {at[0], at[1], at[2]}, second[3] = {at[0], at[2], at[3]};
    if (count == 4)
        return stp_min(stp_triangle_distance(p, first), stp_triangle_distance(p, second));
    const stp_dvec3 only[3] = {at[(missing + 1) % 4], at[(missing + 2) % 4], at[(missing + 3) % 4]};
    return stp_triangle_distance(p, only);
}

/* The first of three squares about a place, of `count` in a row. */
static int64_t first_square(double at, uint32_t count)
{
    return (int64_t)stp_min(stp_max(floor(at), 0.0), count - 1.0) - 1;
}

double stp_map_distance(const stp_map *map, stp_dvec3 world)
{
    const stp_dvec3 p = stp_map_frame_local(&map->frame, world);
    const uint32_t columns = map->columns - 1, rows = map->rows - 1;
    const int64_t column = first_square(p.x / map->frame.spacing, columns);
    const int64_t row = first_square(p.y / map->frame.spacing, rows);
    double least = INFINITY;
    for (int64_t r = row; r < row + 3; r++)
        for (int64_t c = column; c < column + 3; c++)
            if (r >= 0 && r < rows && c >= 0 && c < columns)
                least = stp_min(least, to_square(map, (uint32_t)c, (uint32_t)r, p));
    return least;
}
