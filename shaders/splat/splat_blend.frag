// Splatting, attribute pass: adds up the splats of the front surface.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "splat_bins.glsl"
#include "splat_gather.glsl"
#include "splat_add.glsl"

layout(binding = 8) uniform sampler2D front_end; // encoded by stp_depth_encode

layout(location = 0) out vec4 normal_sum; // w: sum of the weights
layout(location = 1) out vec4 colour_sum; // w: sum of distances before the front's end, in pixels

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    stp_splat_pixel p = stp_splat_begin(here, stp_depth_decode(texelFetch(front_end, here, 0).x));
    stp_splat_walk(p, here);
    normal_sum = p.normal * (1.0 / STP_SPLAT_STEPS);
    colour_sum = p.colour * (1.0 / STP_SPLAT_STEPS);
}
