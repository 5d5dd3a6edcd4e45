// The samples that a picture projects, one per invocation of a compute shader. The samples are in
// runs or in a list. Needs layout.glsl, patch.glsl, runs.glsl.

layout(local_size_x = STP_GROUP_RUNS * STP_RUN_SAMPLES) in;

layout(binding = 9) uniform usamplerBuffer run_texture;     // the buffer of runs
layout(binding = 10) uniform samplerBuffer lattice_texture; // the buffer of lattices

layout(std430, binding = 1) readonly buffer stp_listed_block {
    uint listed[];
};

layout(location = 4) uniform uint listed_count; // 0: use the runs

// Finds the sample of this invocation, its lattice relative to the eye, and `opened` for
// stp_culled. False if this invocation has no sample.
bool stp_find(out uint index, out vec4 lattice, out bool opened)
{
    opened = true;
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (listed_count != 0u) {
        uint at = group * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
        if (at >= listed_count)
            return false;
        index = listed[at];
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
    lattice = texelFetch(lattice_texture, int(run.y & ~STP_RUN_OPENED));
    opened = (run.y & STP_RUN_OPENED) != 0u;
    index = (run.x & 0x1fffffffu) + lane;
    return true;
}

// Counts a dropped sample of the runs. No road checks listed samples one by one
// (runtime/draw/runs.h).
void stp_count_dropped()
{
    if (listed_count == 0u)
        atomicAdd(dropped[gl_WorkGroupID.x % STP_DROP_COUNTERS * STP_DROP_STRIDE], 1u);
}
