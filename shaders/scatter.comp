// Projection without the rasteriser, second step: an invocation is a sample. In one pass over all of
// them the pixels take their nearest depth, in another the names of the samples that have it.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "runs.glsl"
#include "listed.glsl"

layout(r32ui, binding = 0) uniform uimage2D nearest_depth; // bits of a float that is never negative
layout(r32ui, binding = 1) uniform uimage2D nearest_sample;

layout(location = 1) uniform bool naming;

void main()
{
    uint index;
    vec4 lattice;
    ivec2 pixel;
    float z;
    if (!stp_find(index, lattice) ||
        !stp_place(texelFetch(object_texture, int(index)), lattice.xyz, lattice.w, pixel, z))
        return;
    z = stp_depth_apart(z, listed_count != 0u ? STP_ORDER_VERTEX : STP_ORDER_SAMPLE); // the vertices are listed
    // The nearest of all; the first of equals.
    if (!naming)
        imageAtomicMax(nearest_depth, pixel, floatBitsToUint(z));
    else if (imageLoad(nearest_depth, pixel).x == floatBitsToUint(z))
        imageAtomicMin(nearest_sample, pixel, index);
}
