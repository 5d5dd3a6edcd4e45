// The runs of samples: runs.comp lists them, other compute shaders draw them (listed.glsl).
// runtime/draw/runs.c makes the buffers.

#define STP_RUN_STEP 64u // size of a group
#define STP_RUN_SAMPLES 4u
#define STP_DROP_COUNTERS 64u // each in a cache line of its own
#define STP_DROP_STRIDE 16u
#define STP_RUN_HEAD (1u + STP_DROP_COUNTERS * STP_DROP_STRIDE / 2u) // in sizes of a run

layout(std430, binding = 2) buffer stp_runs_block {
    uint run_count;
    uint points_listed;
    uint dropped[STP_DROP_COUNTERS * STP_DROP_STRIDE]; // their sum: samples in runs that are not drawn
    // Index of the patch in sight; number of the first sample in the patch | place of its name << 8 | samples << 16.
    uvec2 runs[];
};

// Four uvec4 for each patch in sight. First: bits of its lattice, that is origin relative to the eye,
// and step, a power of 2, in whose low bits its number is. Second: stp_patch_openings. Then the members of its
// stp_packing that projection needs: first, widths, and three words of the vertex.
#define STP_SEEN_SIZE 4u
layout(std430, binding = 3) buffer stp_seen_block {
    uvec4 seen[];
};

// Each group takes its share of some items: whole steps, one after the other.
uint stp_share(uint count)
{
    uint steps = (count + STP_RUN_STEP - 1u) / STP_RUN_STEP;
    return (steps + gl_NumWorkGroups.x - 1u) / gl_NumWorkGroups.x * STP_RUN_STEP;
}

uint stp_share_first(uint count)
{
    return gl_WorkGroupID.x * stp_share(count) + gl_LocalInvocationID.x;
}

uint stp_share_end(uint count)
{
    return min((gl_WorkGroupID.x + 1u) * stp_share(count), count);
}

uvec2 stp_run_pack(uint listed, uint number, uint place, uint count)
{
    return uvec2(listed, number | place << 8 | count << 16);
}
