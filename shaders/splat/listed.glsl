// The samples that a picture projects. They are in runs, or, if STP_LISTED, in a list of names of patch
// vertices (STP_LISTED_VERTICES) or of whatever the CPU chose. A software driver runs both sides of a branch, so each
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
    uint name;
    bool narrow;
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
    s.name = listed[place];
    uint patch_index = stp_name_patch(s.name), slot = stp_patch_slot(patch_index);
    stp_chunk chunk = stp_chunk_fetch(slot);
#ifdef STP_LISTED_VERTICES
    s.index = chunk.first.w + patch_index;
#else
    s.index = stp_name_index(s.name, chunk);
#endif
    s.narrow = stp_narrow(chunk.colours);
    s.lattice = stp_lattice_fetch(patch_index, chunk.offset);
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
    uint lane = place % STP_RUN_SAMPLES, patch_in_sight = run.y & 0x3fffffu;
    s.index = (run.x & 0x1fffffffu) + lane;
    uvec4 lattice = imageLoad(seen_image, int(2u * patch_in_sight));
    s.narrow = (lattice.w & STP_SEEN_NARROW) != 0u;
    s.name = ((lattice.w & STP_SEEN_NARROW - 1u) << STP_NAME_PATCH_SHIFT) + (run.y >> 22) + lane;
    s.lattice = uintBitsToFloat(uvec4(lattice.xyz, lattice.w & 0xff800000u));
    s.openings = imageLoad(seen_image, int(2u * patch_in_sight + 1u));
    return lane <= run.x >> 29;
}

// Counts dropped samples of the runs.
void stp_count_dropped(uint count)
{
    atomicAdd(dropped[gl_WorkGroupID.x % STP_DROP_COUNTERS * STP_DROP_STRIDE], count);
}
#endif
