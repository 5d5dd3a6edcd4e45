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
layout(location = 6) uniform bool first_pass;

const uint RAISED = 0xfffffffeu; // in later passes: nearer than before, not named yet

uint chunk_of(uint index)
{
    return stp_chunk_fetch(stp_patch_slot(texelFetch(patch_of_sample, int(index)).x)).id;
}

// The order that the other roads draw in. Where chunks lie in the Object Texture depends on what was drawn before.
bool comes_first(uint a, uint b)
{
    uint p = chunk_of(a), q = chunk_of(b);
    return p < q || p == q && a < b;
}

// The first of equals is the pixel's. One that an earlier pass has named, and no sample of this one is in front of,
// stays: the pixel is not marked.
void name(ivec2 pixel, uint index)
{
    uint had = imageAtomicCompSwap(nearest_sample, pixel, first_pass ? STP_NO_SAMPLE : RAISED, index);
    while (had < RAISED && comes_first(index, had)) {
        uint now = imageAtomicCompSwap(nearest_sample, pixel, had, index);
        if (now == had)
            break;
        had = now;
    }
}

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
    uint bits = floatBitsToUint(z);
    if (naming) {
        if (imageLoad(nearest_depth, pixel).x == bits)
            name(pixel, index);
    } else if (imageAtomicMax(nearest_depth, pixel, bits) < bits && !first_pass) {
        imageStore(nearest_sample, pixel, uvec4(RAISED));
    }
}
