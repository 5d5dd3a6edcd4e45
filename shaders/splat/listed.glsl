// The samples that a picture projects. They are in runs, or, if STP_LISTED, in a list of patch
// vertices or of whatever the CPU chose. A software driver runs both sides of a branch, so each
// needs a program of its own (stp_each in runtime/draw/runs.h). An invocation goes through several
// samples:
//
//     for (uint place = stp_first_place(); place < stp_end_place(); place += STP_PLACE_STEP)
//         if (stp_find(place, s)) ...
//
// Needs layout.glsl, patch.glsl, project.glsl, runs.glsl.

#define STP_PLACE_STEP 64u // size of a group
#define STP_GROUP_PLACES (STP_GROUP_RUNS * STP_RUN_SAMPLES)

layout(local_size_x = STP_PLACE_STEP) in;

// A sample to project.
struct stp_projected {
    uint index;     // in the Object Texture
    vec4 lattice;   // of its patch: origin relative to the eye, step
    uvec4 openings; // for stp_culled
};

uint stp_group_place()
{
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * STP_GROUP_PLACES;
}

uint stp_first_place()
{
    return stp_group_place() + gl_LocalInvocationID.x;
}

#if STP_LISTED
layout(std430, binding = 1) readonly buffer stp_listed_block {
    uint listed[];
};

layout(location = 4) uniform uint listed_count;

uint stp_end_place()
{
    return min(stp_group_place() + STP_GROUP_PLACES, listed_count);
}

// The sample at a place; false if there is none.
bool stp_find(uint place, out stp_projected s)
{
    s.index = listed[place];
    uint patch_index = texelFetch(patch_of_sample, int(s.index)).x;
    uint slot = stp_patch_slot(patch_index);
    s.lattice = stp_lattice_fetch(patch_index, stp_chunk_fetch(slot).offset);
    s.openings = stp_chunk_openings(slot);
    return true;
}

// No road checks listed samples one by one (runtime/draw/runs.h).
void stp_count_dropped(uint count)
{
}
#else
layout(rg32ui, binding = 2) readonly uniform uimageBuffer run_image;    // the buffer of runs
layout(rgba32ui, binding = 3) readonly uniform uimageBuffer seen_image; // the buffer of patches in sight

uint stp_end_place()
{
    return min(stp_group_place() + STP_GROUP_PLACES, run_count * STP_RUN_SAMPLES);
}

bool stp_find(uint place, out stp_projected s)
{
    uvec2 run = imageLoad(run_image, int(place / STP_RUN_SAMPLES + STP_RUN_HEAD)).xy;
    uint lane = place % STP_RUN_SAMPLES;
    s.index = (run.x & 0x1fffffffu) + lane;
    s.lattice = uintBitsToFloat(imageLoad(seen_image, int(2u * run.y)));
    s.openings = imageLoad(seen_image, int(2u * run.y + 1u));
    return lane <= run.x >> 29;
}

// Counts dropped samples of the runs.
void stp_count_dropped(uint count)
{
    atomicAdd(dropped[gl_WorkGroupID.x % STP_DROP_COUNTERS * STP_DROP_STRIDE], count);
}
#endif
