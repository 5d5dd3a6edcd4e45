// The runs of samples: runs.comp lists them, other compute shaders draw them (listed.glsl).
// runtime/draw/runs.c makes the buffers.

#define STP_GROUP_PATCHES 64u
#define STP_RUN_SAMPLES 4u
#define STP_GROUP_RUNS 64u
#define STP_DROP_COUNTERS 64u // each in a cache line of its own
#define STP_DROP_STRIDE 16u
#define STP_RUN_HEAD (3u + STP_DROP_COUNTERS * STP_DROP_STRIDE / 2u) // in sizes of a run

layout(std430, binding = 2) buffer stp_runs_block {
    uint groups_x; // size of the dispatch over the runs; x is given
    uint groups_y;
    uint groups_z;
    uint run_count;
    uint points_listed;
    uint unused;
    uint dropped[STP_DROP_COUNTERS * STP_DROP_STRIDE]; // listed samples less their sum: those drawn
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

uvec2 stp_run_pack(uint listed, uint number, uint place, uint count)
{
    return uvec2(listed, number | place << 8 | count << 16);
}
