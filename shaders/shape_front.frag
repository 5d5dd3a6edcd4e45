// Splatting, visibility pass: names the triangle of a pixel, by where its interval ends.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "choose.glsl"
#include "palette.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "shape.glsl"
#include "sample_pixel.glsl"

flat in uint id;

layout(location = 0) out uint nearest;

void main()
{
    uvec2 name = uvec2(id, texelFetch(patch_of_sample, int(id & STP_NAME_SAMPLE)).x);
    nearest = id;
    gl_FragDepth = stp_depth_encode(stp_sample_pixel(name, gl_FragCoord.xy).z_max);
}
