// Projection without the rasteriser, first step: chooses the level of every patch and lists its
// samples in runs of up to STP_RUN_SAMPLES. In any order: scatter.comp's result does not depend on it.
#include "layout.glsl"
#include "patch.glsl"
#include "choose.glsl"
#include "runs.glsl"

layout(local_size_x = STP_GROUP_PATCHES) in;

layout(std430, binding = 1) readonly buffer stp_groups_block {
    uvec4 groups[]; // first patch, patches, slot of their chunk
};

layout(location = 1) uniform uint group_count;

void stp_list(uint patch_index, uint slot)
{
    stp_chunk chunk = stp_chunk_fetch(slot);
    stp_patch p = stp_patch_fetch(patch_index, chunk.offset);
    int level = stp_choose_level(p, chunk);
    uint count = level == STP_LEVEL_SKIP ? 0u : p.count[max(level, 0)];
    if (count == 0u)
        return;
    uint first = p.first[level];
    uint needed = (count + STP_RUN_SAMPLES - 1u) / STP_RUN_SAMPLES;
    uint at = atomicAdd(run_count, needed);
    atomicAdd(points_drawn, count);
    atomicMax(groups_y, (at + needed - 1u) / (groups_x * STP_GROUP_RUNS) + 1u);
    lattices[patch_index] = vec4(p.origin, p.step);
    for (uint i = 0u; i < count; i += STP_RUN_SAMPLES) {
        runs[at] = stp_run_pack(first + i, min(count - i, STP_RUN_SAMPLES), patch_index);
        at++;
    }
}

void main()
{
    uint share = (group_count + gl_NumWorkGroups.x - 1u) / gl_NumWorkGroups.x;
    uint begin = gl_WorkGroupID.x * share;
    for (uint g = begin; g < min(begin + share, group_count); g++) {
        uvec4 group = groups[g];
        if (gl_LocalInvocationID.x < group.y)
            stp_list(group.x + gl_LocalInvocationID.x, group.z);
    }
}
