// Projection without the rasteriser, second step: an invocation is a sample. In one pass over all of them the pixels
// take their nearest depth (scatter_depth.comp), in another the names of the samples that have it (scatter_name.comp).
// Two programs: software rasterisers run both sides of a branch, one sample after the other where there are atomics.

layout(r32ui, binding = 0) uniform uimage2D nearest_depth; // bits of a float that is never negative
layout(r32ui, binding = 1) uniform uimage2D nearest_sample;

layout(location = 6) uniform bool first_pass;

const uint RAISED = 0xfffffffeu; // in later passes: nearer than before, not named yet

// Where a sample goes, and its depth. False if it is not drawn.
bool stp_scatter_place(uint index, vec4 lattice, bool opened, out ivec2 pixel, out uint bits)
{
    float z;
    bool drawn = stp_place(texelFetch(object_texture, int(index)), lattice.xyz, lattice.w, opened, pixel, z);
    z = stp_depth_apart(z, listed_count != 0u ? STP_ORDER_VERTEX : STP_ORDER_SAMPLE); // the vertices are listed
    bits = floatBitsToUint(z);
    return drawn;
}
