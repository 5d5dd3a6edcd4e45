// The runs of samples: runs.comp lists them, other compute shaders draw them (listed.glsl).
// runtime/draw/runs.c makes the buffers.

#define STP_GROUP_PATCHES 64u
#define STP_RUN_SAMPLES 4u
#define STP_GROUP_RUNS 16u
#define STP_DROP_COUNTERS 64u // each in a cache line of its own
#define STP_DROP_STRIDE 16u
#define STP_RUN_HEAD (3u + STP_DROP_COUNTERS * STP_DROP_STRIDE / 2u) // in sizes of a run
#define STP_RUN_OPENED 0x80000000u // its patch may be seen through an opening (stp_patch_opened)

layout(std430, binding = 2) buffer stp_runs_block {
    uint groups_x; // size of the dispatch over the runs; x is given
    uint groups_y;
    uint groups_z;
    uint run_count;
    uint points_listed;
    uint unused;
    uint dropped[STP_DROP_COUNTERS * STP_DROP_STRIDE]; // their sum: samples in runs that are not drawn
    uvec2 runs[]; // first sample | (samples - 1) << 29; index of the patch in sight | STP_RUN_OPENED
};

// Lattices of the patches in sight: origin relative to the eye, step.
layout(std430, binding = 3) buffer stp_lattices_block {
    vec4 lattices[];
};

uvec2 stp_run_pack(uint first, uint count, uint listed, bool opened)
{
    return uvec2(first | count - 1u << 29, listed | (opened ? STP_RUN_OPENED : 0u));
}
