// The runs of samples that runs.comp lists and other compute shaders draw (listed.glsl); runtime/runs.c makes
// the buffers.

#define STP_GROUP_PATCHES 64u
#define STP_RUN_SAMPLES 4u
#define STP_GROUP_RUNS 16u
#define STP_RUN_HEAD 3u // of the size of runs

layout(std430, binding = 2) buffer stp_runs_block {
    uint groups_x; // of the dispatch over them: x is given
    uint groups_y;
    uint groups_z;
    uint run_count;
    uint points_drawn;
    uint unused;
    uvec2 runs[]; // first sample | (samples - 1) << 29, which patch in sight
};

// Of the patches in sight: origin relative to the eye, step.
layout(std430, binding = 3) buffer stp_lattices_block {
    vec4 lattices[];
};

uvec2 stp_run_pack(uint first, uint count, uint listed)
{
    return uvec2(first | count - 1u << 29, listed);
}
