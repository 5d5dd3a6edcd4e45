// Pulls a level from the next finer level.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "pixel.glsl"
#include "pixel_out.glsl"
#include "ellipse.glsl"
#include "blend.glsl"
#include "template.glsl"
#include "pull.glsl"

void main()
{
    stp_pixel_write(stp_pull_fine(ivec2(gl_FragCoord.xy), pyramid_level));
}
