// Splats of elevation maps, second step: names the nearest splat of each pixel.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "square.glsl"
#include "map.glsl"
#include "scattered.glsl"
#include "splat_bins.glsl"
#include "splat_gather.glsl"

layout(location = 0) out uint nearest;

void stp_splat_take(inout stp_splat_pixel p, stp_splat_seen s)
{
    float depth = s.depth;
#if STP_MAPS == STP_MAPS_SPLATS
    // Without neighbours at this place a splat counts only where no other splat does.
    vec2 way = s.offset * stp_square_grid_fetch(s.splat >> 6);
    bool known = (floatBitsToUint(s.extent) >> stp_map_triangle(way) & 1u) != 0u;
    depth += known ? 0.0 : 2.0 * s.extent;
    s.covers = s.covers && max(abs(way.x), abs(way.y)) <= STP_MAP_REACH;
#endif
    if (s.covers && (depth < p.end || depth == p.end && s.splat < p.front)) {
        p.end = depth;
        p.front = s.splat;
        p.front_q = s.extent;
    }
}

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    stp_splat_pixel p = stp_splat_begin(here, STP_ELLIPSE_OUTSIDE);
    stp_splat_walk(p, here);
    float z = stp_depth_apart(stp_depth_encode(p.end), STP_ORDER_SHAPE);
    if (p.front == STP_NO_SAMPLE || stp_scattered_before(z))
        discard;
    bool border = (floatBitsToUint(p.front_q) & 255u) != 255u;
    nearest = STP_NAME_SQUARE | p.front << STP_NAME_PLACE_SHIFT | STP_SQUARE_SPLAT | (border ? STP_SQUARE_BORDER : 0u);
    gl_FragDepth = z;
}
