// Splatting, attribute pass: adds up what the splats of the front surface say, by their Gaussians.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "splat_in.glsl"

layout(binding = 8) uniform sampler2D front_end; // as stp_depth_encode has it

layout(location = 0) out vec4 normal_sum; // and of the weights
layout(location = 1) out vec4 colour_sum; // and of how far before the front's end the splats lie

void main()
{
    vec2 met = stp_splat_meet();
    float end = stp_depth_decode(texelFetch(front_end, ivec2(gl_FragCoord.xy), 0).x);
    float before = end - met.y;
    if (!(met.x <= 1.0) || before < 0.0)
        discard;
    float weight = exp(-2.0 * met.x);
    normal_sum = weight * vec4(splat_plane.xyz, 1.0);
    colour_sum = weight * vec4(stp_splat_colour(), before);
}
