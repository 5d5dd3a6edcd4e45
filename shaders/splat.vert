// One vertex is one sample, drawn as a splat.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "choose.glsl"
#include "palette.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "shape.glsl"
#include "sample_pixel.glsl"
#include "splat_out.glsl"

layout(location = 1) in uint patch_index;

void main()
{
    stp_splat_write(uvec2(gl_VertexID, patch_index));
}
