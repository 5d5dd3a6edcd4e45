// Splatting, attribute pass: adds up the splats of the front surface, weighted by their Gaussians.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "splat_bins.glsl"
#include "splat_gather.glsl"

layout(binding = 8) uniform sampler2D front_end; // encoded by stp_depth_encode

layout(location = 0) out vec4 normal_sum; // w: sum of the weights
layout(location = 1) out vec4 colour_sum; // w: sum of distances before the front's end, in pixels

// Terms are rounded to 1 / STP_SPLAT_STEPS. So sums up to 256 are exact, and the same in any order.
#define STP_SPLAT_STEPS 65536.0

vec3 stp_splat_colour(uint code)
{
    const vec3 most = vec3(2047.0, 2047.0, 1023.0);
    return vec3(uvec3(code, code >> 11, code >> 22) & uvec3(most)) * (1.0 / most);
}

void stp_splat_take(inout stp_splat_pixel p, stp_splat_seen s)
{
    bool counts = s.covers && s.depth <= p.end;
    float weight = counts ? STP_SPLAT_STEPS * exp(-2.0 * s.q) : 0.0;
    // Without `counts` there may be no end, and the product would not be a number.
    float before = counts ? (p.end - s.depth) * stp_pixels_per_unit(p.end) : 0.0;
    uint look = texelFetch(look_texture, int(s.splat)).x;
    p.normal += roundEven(weight * vec4(s.normal, 1.0));
    p.colour += roundEven(weight * vec4(stp_splat_colour(look), before));
}

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    stp_splat_pixel p = stp_splat_begin(here, stp_depth_decode(texelFetch(front_end, here, 0).x));
    stp_splat_walk(p, here);
    normal_sum = p.normal * (1.0 / STP_SPLAT_STEPS);
    colour_sum = p.colour * (1.0 / STP_SPLAT_STEPS);
}
