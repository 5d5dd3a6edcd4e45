// Names the samples that have the nearest depth (scatter.glsl). Counts the samples that are not
// drawn.
#define STP_FRAME_HELD
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
    uint p = stp_patch_order(texelFetch(patch_of_sample, int(a)).x);
    uint q = stp_patch_order(texelFetch(patch_of_sample, int(b)).x);
    return p < q || p == q && a < b;
}

// Gives the pixel to a sample if `nearest`, and to the first of equal samples. If an earlier pass has
// named the pixel, and no sample of this pass is nearer, the pixel is not RAISED and keeps its name.
// unnamed: what a pixel without a name holds.
void name(ivec2 pixel, uint index, bool nearest, uint unnamed)
{
    uint had = STP_NO_SAMPLE;
    if (nearest)
        had = imageAtomicCompSwap(nearest_sample, pixel, unnamed, index);
    bool tied = had < RAISED;
    // A software driver always looks up once. Without a tie it looks up sample 0, which stays in its
    // cache and does not come before itself.
    while (comes_first(tied ? index : 0u, tied ? had : 0u)) {
        uint now = imageAtomicCompSwap(nearest_sample, pixel, had, index);
        tied = now != had;
        had = now;
    }
}

void main()
{
    stp_frame_hold();
    bool counts = counting;
    uint unnamed = first_pass ? STP_NO_SAMPLE : RAISED, end = stp_end_place();
    for (uint place = stp_first_place(); place < end; place += STP_PLACE_STEP) {
        stp_projected s;
        ivec2 pixel;
        uint bits;
        if (!stp_find(place, s))
            continue;
        bool drawn = stp_scatter_place(s, pixel, bits);
        if (counts && !drawn)
            stp_count_dropped();
        name(pixel, s.index, drawn && imageLoad(nearest_depth, pixel).x == bits, unnamed);
    }
}
