// Splatting, visibility pass: of each pixel the least end of the intervals of all splats that cover it, and whose
// it is. What begins before that end is the front surface.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "splat_in.glsl"

layout(location = 0) out uint nearest;

void main()
{
    vec2 met = stp_splat_meet();
    if (!(met.x <= 1.0))
        discard;
    nearest = splat_look.z;
    gl_FragDepth = stp_depth_encode(max(met.y + splat_plane.w, viewport.w));
}
