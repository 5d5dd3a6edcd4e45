// Names the samples that have the nearest depth (scatter.glsl). Counts the samples that are not
// drawn.
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

// Gives the pixel to the first of equal samples. If an earlier pass has named the pixel, and no
// sample of this pass is nearer, the pixel is not RAISED and keeps its name.
void name(ivec2 pixel, uint index)
{
    uint had = imageAtomicCompSwap(nearest_sample, pixel, first_pass ? STP_NO_SAMPLE : RAISED, index);
    while (had < RAISED && comes_first(index, had)) {
        uint now = imageAtomicCompSwap(nearest_sample, pixel, had, index);
        if (now == had)
            break;
        had = now;
    }
}

void main()
{
    uint index, bits;
    vec4 lattice;
    bool opened;
    ivec2 pixel;
    if (!stp_find(index, lattice, opened))
        return;
    bool drawn = stp_scatter_place(index, lattice, opened, pixel, bits);
    if (counting && !drawn)
        stp_count_dropped();
    if (drawn && imageLoad(nearest_depth, pixel).x == bits)
        name(pixel, index);
}
