// Finds the nearest depth of each pixel (scatter.glsl).
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "runs.glsl"
#include "listed.glsl"
#include "scatter.glsl"

void main()
{
    uint index, bits;
    vec4 lattice;
    bool opened;
    ivec2 pixel;
    if (!stp_find(index, lattice, opened) || !stp_scatter_place(index, lattice, opened, pixel, bits))
        return;
    if (imageAtomicMax(nearest_depth, pixel, bits) < bits && !first_pass)
        imageStore(nearest_sample, pixel, uvec4(RAISED));
}
