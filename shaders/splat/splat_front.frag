// Splatting, visibility pass: finds the least end of the intervals of all splats that cover a
// pixel, and the splat that has it. Splats that begin before that end are the front surface.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "splat_bins.glsl"
#include "splat_gather.glsl"

layout(location = 0) out uint nearest;

void stp_splat_take(inout stp_splat_pixel p, stp_splat_seen s)
{
    float end = s.depth + s.extent;
    if (s.covers && (end < p.end || end == p.end && s.q < p.front_q)) {
        p.end = end;
        p.front = s.splat;
        p.front_q = s.q;
    }
}

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    stp_splat_pixel p = stp_splat_begin(here, STP_ELLIPSE_OUTSIDE);
    stp_splat_walk(p, here);
    if (p.front == STP_NO_SAMPLE)
        discard;
    nearest = texelFetch(look_texture, int(p.front)).y;
    gl_FragDepth = stp_depth_encode(p.end);
}
