// Projection without the rasteriser, second step: an invocation is a sample. In one pass over all of
// them the pixels take their nearest depth, in another the names of the samples that have it.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "runs.glsl"

layout(local_size_x = STP_GROUP_RUNS * STP_RUN_SAMPLES) in;

layout(binding = 9) uniform usamplerBuffer run_texture;     // of the runs' buffer
layout(binding = 10) uniform samplerBuffer lattice_texture; // and the lattices'
layout(r32ui, binding = 0) uniform uimage2D nearest_depth;  // bits of a float that is never negative
layout(r32ui, binding = 1) uniform uimage2D nearest_sample;

layout(std430, binding = 1) readonly buffer stp_vertices_block {
    uint vertices[]; // patches' only samples at level 3
};

layout(location = 1) uniform bool naming;
layout(location = 4) uniform uint vertex_count; // 0: the runs

// A sample, and its lattice relative to the eye; false where there is none for this invocation.
bool stp_find(out uint index, out vec4 lattice)
{
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (vertex_count != 0u) {
        uint at = group * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
        if (at >= vertex_count)
            return false;
        index = vertices[at];
        uint patch_index = texelFetch(patch_of_sample, int(index)).x;
        vec3 offset = stp_chunk_fetch(stp_patch_slot(patch_index)).offset;
        lattice = stp_lattice_fetch(patch_index, offset);
        return true;
    }
    uint at = group * STP_GROUP_RUNS + gl_LocalInvocationID.x / STP_RUN_SAMPLES;
    uint lane = gl_LocalInvocationID.x & STP_RUN_SAMPLES - 1u;
    uvec2 run = texelFetch(run_texture, int(at + STP_RUN_HEAD)).xy;
    if (at >= run_count || lane > run.x >> 29)
        return false;
    lattice = texelFetch(lattice_texture, int(run.y));
    index = (run.x & 0x1fffffffu) + lane;
    return true;
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
    z = stp_depth_apart(z, vertex_count != 0u ? STP_ORDER_VERTEX : STP_ORDER_SAMPLE);
    // The nearest of all; the first of equals.
    if (!naming)
        imageAtomicMax(nearest_depth, pixel, floatBitsToUint(z));
    else if (imageLoad(nearest_depth, pixel).x == floatBitsToUint(z))
        imageAtomicMin(nearest_sample, pixel, index);
}
