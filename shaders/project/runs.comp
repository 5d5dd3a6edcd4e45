// Projection without the rasteriser, first step: chooses the levels of every patch and lists the
// samples in runs of up to STP_RUN_SAMPLES. The order of runs is random; no picture depends on it.
#define STP_FRAME_HELD
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "choose.glsl"
#include "runs.glsl"

layout(local_size_x = STP_GROUP_PATCHES) in;

layout(std430, binding = 1) readonly buffer stp_patches_block {
    uint patches[]; // in sight
};

layout(location = 1) uniform uint patch_count;

void stp_list(uint listed)
{
    uint patch_index = patches[listed];
    uint slot = stp_patch_slot(patch_index);
    stp_chunk chunk = stp_chunk_fetch(slot);
    stp_patch p = stp_patch_fetch(patch_index, chunk);
    ivec4 levels = stp_choose_levels(patch_index, p, chunk);
    stp_selection s = stp_select(p, levels);
    if (s.end.w == 0u || stp_shape_of(p, levels.x) != 0u)
        return;
    // Quarters of the same level follow each other: join a quarter to the next one if that
    // continues it.
    uvec4 count = s.end - uvec4(0u, s.end.xyz);
    for (int q = 2; q >= 0; q--)
        if (s.first[q] + count[q] == s.first[q + 1]) {
            count[q] += count[q + 1];
            count[q + 1] = 0u;
        }
    uvec4 needed = (count + STP_RUN_SAMPLES - 1u) / STP_RUN_SAMPLES;
    uint total = needed.x + needed.y + needed.z + needed.w;
    uint at = atomicAdd(run_count, total);
    atomicAdd(points_listed, s.end.w);
    atomicMax(groups_y, (at + total - 1u) / (groups_x * STP_GROUP_RUNS) + 1u);
    stp_packing packing = stp_packing_fetch(patch_index);
    seen[STP_SEEN_SIZE * listed] = floatBitsToUint(vec4(p.origin, p.step)) | uvec4(0u, 0u, 0u, patch_index);
    seen[STP_SEEN_SIZE * listed + 1u] = stp_patch_openings(p, slot);
    seen[STP_SEEN_SIZE * listed + 2u] = uvec4(packing.first, packing.widths, packing.vertex.x);
    seen[STP_SEEN_SIZE * listed + 3u] = uvec4(packing.vertex.yz, 0u, 0u);
    uvec4 places = stp_selection_names(s, 0u, p, levels);
    for (int q = 0; q < STP_QUARTERS; q++)
        for (uint i = 0u; i < count[q]; i += STP_RUN_SAMPLES) {
            runs[at] = stp_run_pack(listed, s.first[q] + i, places[q] + i, min(count[q] - i, STP_RUN_SAMPLES));
            at++;
        }
}

void main()
{
    stp_frame_hold();
    uint share = (patch_count + gl_NumWorkGroups.x - 1u) / gl_NumWorkGroups.x;
    uint end = min((gl_WorkGroupID.x + 1u) * share, patch_count);
    for (uint i = gl_WorkGroupID.x * share + gl_LocalInvocationID.x; i < end; i += STP_GROUP_PATCHES)
        stp_list(i);
}
