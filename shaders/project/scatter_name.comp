// Names the samples that have the nearest depth (scatter.glsl). Counts the samples that are not
// drawn.
#define STP_FRAME_HELD
#define STP_LISTED_VERTICES
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "runs.glsl"
#include "listed.glsl"
#include "scatter.glsl"

layout(location = 1) uniform bool counting;

// The order in which the other roads draw. Positions in the Object Texture would depend on earlier
// frames.
bool comes_first(uint a, uint b)
{
    uint p = stp_chunk_fetch(stp_patch_slot(stp_name_patch(a))).order;
    uint q = stp_chunk_fetch(stp_patch_slot(stp_name_patch(b))).order;
    return p < q || p == q && a < b;
}

// Whether sample i of a run has the nearest depth of its pixel.
bool is_nearest(stp_run r, uint run, uint i, out ivec2 pixel, out bool drawn)
{
    uint bits;
#if STP_PLACES
    uvec2 place = imageLoad(place_image, int(first_place + stp_run_place(run, i))).xy;
    drawn = place.x != NOT_DRAWN;
    pixel = ivec2(place.x & 65535u, place.x >> 16);
    bits = place.y;
#else
    drawn = stp_scatter_place(r, stp_run_sample(r, i).texel, pixel, bits);
#endif
    return drawn && imageLoad(nearest_depth, pixel).x == bits;
}

// Gives a pixel to a sample that comes before the one it has a name of, if `asked`.
void settle(ivec2 pixel, uint name, bool asked)
{
    uint had = asked ? imageLoad(nearest_sample, pixel).x : STP_NO_SAMPLE;
    bool tied = had < RAISED;
    // A software driver always looks up once. Without a tie it looks up sample 0, which stays in its
    // cache and does not come before itself.
    while (comes_first(tied ? name : 0u, tied ? had : 0u)) {
        uint now = imageAtomicCompSwap(nearest_sample, pixel, had, name);
        tied = now != had;
        had = now;
    }
}

// Names pixels that have no name. If an earlier pass has named a pixel, and no sample of this pass is
// nearer, the pixel is not RAISED and stays as it is. Ties are few, so the samples of an invocation
// that met one are looked at again.
void main()
{
    stp_frame_hold();
    bool counts = counting, met = false;
    uint miscounted = 0u;
    uint unnamed = first_pass ? STP_NO_SAMPLE : RAISED, end = stp_end_run();
    for (uint run = stp_first_run(); run < end; run += STP_RUN_STEP) {
        stp_run r = stp_run_fetch(run);
        for (uint i = 0u; i < stp_run_count(r); i++) {
            ivec2 pixel;
            bool drawn;
            if (is_nearest(r, run, i, pixel, drawn) && imageAtomicCompSwap(nearest_sample, pixel, unnamed, r.name + i) < RAISED)
                met = true;
            miscounted += stp_miscounted(drawn);
        }
    }
    if (counts && miscounted != 0u)
        stp_correct_count(miscounted);
    for (uint run = met ? stp_first_run() : end; run < end; run += STP_RUN_STEP) {
        stp_run r = stp_run_fetch(run);
        for (uint i = 0u; i < stp_run_count(r); i++) {
            ivec2 pixel;
            bool drawn, nearest = is_nearest(r, run, i, pixel, drawn);
            settle(pixel, r.name + i, nearest);
        }
    }
}
