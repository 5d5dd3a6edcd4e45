// Turns the nearest sample of each pixel into level 0 of the pyramid ("Projection" in README.md).
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "choose.glsl"
#include "palette.glsl"
#include "pixel.glsl"
#include "pixel_out.glsl"
#include "ellipse.glsl"
#include "shape.glsl"
#include "sample_pixel.glsl"

layout(binding = 8) uniform usampler2D nearest_sample;

layout(location = 6) uniform bool first_pass; // of this frame

void main()
{
    uint index = texelFetch(nearest_sample, ivec2(gl_FragCoord.xy), 0).x;
    if (index == STP_NO_SAMPLE && !first_pass) // an earlier pass may have drawn the pixel
        discard;
    uvec2 id = uvec2(index, texelFetch(patch_of_sample, int(index & STP_NAME_SAMPLE)).x);
    stp_pixel p = stp_sample_pixel(id, gl_FragCoord.xy);
    if (index == STP_NO_SAMPLE)
        p = stp_pixel_invalid();
    stp_pixel_write(p);
}
