// Projection without the rasteriser, second step. One pass over all samples finds the nearest depth
// of each pixel (scatter_depth.comp), another names the samples that have it (scatter_name.comp).
// They are two programs because software rasterisers run both sides of a branch, one sample after
// the other if there are atomics.

// coherent: other invocations write what one reads, and a name read late would leave a tie unsettled.
layout(r32ui, binding = 0) coherent uniform uimage2D nearest_depth; // bits of a float that is never negative
layout(r32ui, binding = 1) coherent uniform uimage2D nearest_sample;

layout(location = 6) uniform bool first_pass;

const uint RAISED = 0xfffffffeu; // later passes: a nearer depth that has no name yet

// If STP_PLACES, the first pass keeps where samples lie for the second one: those of listed samples first, then those of
// patches drawn at level 2. Pixel: x | y << 16, or NOT_DRAWN; bits of the depth.
layout(rg32ui, binding = 4) uniform uimageBuffer place_image;
layout(location = 7) uniform uint first_place;

const uint NOT_DRAWN = 0xffffffffu;

// The pixel and the depth of a sample. False if the sample is not drawn.
bool stp_scatter_place(stp_run r, uvec4 texel, out ivec2 pixel, out uint bits)
{
    float z;
    bool drawn = stp_place(texel, r.lattice.xyz, r.lattice.w, r.openings, pixel, z);
    // List 1 holds patch vertices, list 2 and the runs hold other samples.
    z = stp_depth_apart(z, STP_LISTED == 1 ? STP_ORDER_VERTEX : STP_ORDER_SAMPLE);
    bits = floatBitsToUint(z);
    return drawn;
}
