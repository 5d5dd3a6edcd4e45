// The samples that a picture projects, by STP_LISTED. 0: in runs. 1: in a list of names of patch vertices
// (STP_LISTED_VERTICES) or of whatever the CPU chose, one a run. 2: in a list of patches drawn at level 2, a patch a
// run: the name of the first sample | (samples - 1) << STP_NAME_BITS. A software driver runs both sides of a branch, so
// each needs a program of its own (stp_each in runtime/draw/runs.h). An invocation goes through the samples of some runs:
//
//     for (uint run = stp_first_run(); run < stp_end_run(); run += STP_RUN_STEP) {
//         stp_run r = stp_run_fetch(run);
//         for (uint i = 0u; i < stp_run_count(r); i++)
//             ... stp_run_sample(r, i)
//     }
//
// Needs layout.glsl, patch.glsl, project.glsl, runs.glsl.

#define STP_RUN_STEP 64u // size of a group

layout(local_size_x = STP_RUN_STEP) in;

// Some samples of a patch, one after the other.
struct stp_run {
    uint number, name; // of the first
    uint count;        // stp_run_count
    stp_packing packing;
    vec4 lattice;      // of the patch: origin relative to the eye, step
    uvec4 openings;    // for stp_culled
};

// A sample to project.
struct stp_projected {
    uint name;
    uvec4 texel;
};

stp_projected stp_run_sample(stp_run r, uint i)
{
    return stp_projected(r.name + i, stp_sample_words(r.packing, r.number + i));
}

#if STP_LISTED
#define STP_GROUP_LISTED (STP_GROUP_RUNS * STP_RUN_SAMPLES)
#else
#define STP_GROUP_LISTED STP_GROUP_RUNS
#endif

uint stp_group_run()
{
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * STP_GROUP_LISTED;
}

uint stp_first_run()
{
    return stp_group_run() + gl_LocalInvocationID.x;
}

#if STP_LISTED
layout(std430, binding = 1) readonly buffer stp_listed_block {
    uint listed[];
};

layout(location = 4) uniform uint listed_count;

uint stp_end_run()
{
    return min(stp_group_run() + STP_GROUP_LISTED, listed_count);
}

uint stp_run_count(stp_run r)
{
    return STP_LISTED == 2 ? r.count : 1u;
}

stp_run stp_run_fetch(uint run)
{
    stp_run r;
    uint item = listed[run];
    r.name = item & STP_NAME_SAMPLE;
    r.count = 1u + (item >> STP_NAME_BITS);
    uint patch_index = stp_name_patch(r.name), slot = stp_patch_slot(patch_index);
#if STP_LISTED == 2
    r.number = 1u;
    r.packing = stp_packing_fetch(patch_index);
#elif defined(STP_LISTED_VERTICES)
    r.number = 0u;
    r.packing.vertex = stp_vertex_words(stp_patch_samples(patch_index));
#else
    r.number = stp_name_number(r.name, stp_patch_count(patch_index));
    r.packing = stp_packing_fetch(patch_index);
#endif
    r.lattice = stp_lattice_fetch(patch_index, stp_chunk_fetch(slot).offset);
    r.openings = stp_chunk_openings(slot);
    return r;
}

// The place of a sample among those of all runs.
uint stp_run_place(uint run, uint i)
{
    return STP_LISTED == 2 ? run * STP_RUN_SAMPLES + i : run;
}

#if STP_LISTED == 1
// No road checks these samples one by one (runtime/draw/runs.h).
uint stp_miscounted(bool drawn)
{
    return 0u;
}
#else
// No pass has counted these samples.
uint stp_miscounted(bool drawn)
{
    return 0u - uint(drawn);
}
#endif
#else
layout(rg32ui, binding = 2) readonly uniform uimageBuffer run_image;    // the buffer of runs
layout(rgba32ui, binding = 3) readonly uniform uimageBuffer seen_image; // the buffer of patches in sight

uint stp_end_run()
{
    return min(stp_group_run() + STP_GROUP_LISTED, run_count);
}

uint stp_run_count(stp_run r)
{
    return r.count;
}

// Without what projection does not need of the packing.
stp_run stp_run_fetch(uint run)
{
    uvec2 words = imageLoad(run_image, int(run + STP_RUN_HEAD)).xy;
    int seen_at = int(STP_SEEN_SIZE * words.x);
    uvec4 lattice = imageLoad(seen_image, seen_at), first = imageLoad(seen_image, seen_at + 2);
    stp_run r;
    r.number = words.y & 255u;
    r.name = ((lattice.w & 0x7fffffu) << STP_NAME_PATCH_SHIFT) + (words.y >> 8 & 255u);
    r.count = words.y >> 16;
    r.packing = stp_packing_make(first.x, uvec4(first.w, imageLoad(seen_image, seen_at + 3).xy, 0u), first.yz, 0u, uvec2(0u));
    r.lattice = uintBitsToFloat(uvec4(lattice.xyz, lattice.w & 0xff800000u));
    r.openings = imageLoad(seen_image, seen_at + 1);
    return r;
}

uint stp_run_place(uint run, uint i)
{
    return run * STP_RUN_SAMPLES + i;
}

// How many samples too many were counted by runs.comp.
uint stp_miscounted(bool drawn)
{
    return uint(!drawn);
}
#endif

void stp_correct_count(uint miscounted)
{
#if STP_LISTED != 1
    atomicAdd(dropped[gl_WorkGroupID.x % STP_DROP_COUNTERS * STP_DROP_STRIDE], miscounted);
#endif
}
