// Push, coarse to fine: finishes level l. Reads the pulled level l as fine and the finished level l
// + 1 as coarse.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "pixel.glsl"
#include "pixel_out.glsl"
#include "ellipse.glsl"
#include "blend.glsl"
#include "finish.glsl"

void main()
{
    stp_pixel_write(stp_finish(ivec2(gl_FragCoord.xy)));
}
