// Finds the nearest depth of each pixel (scatter.glsl).
#define STP_FRAME_HELD
#define STP_LISTED_VERTICES
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "runs.glsl"
#include "listed.glsl"
#include "scatter.glsl"

void main()
{
    stp_frame_hold();
    bool first = first_pass;
    uint end = stp_end_run();
    for (uint run = stp_first_run(); run < end; run += STP_RUN_STEP) {
        stp_run r = stp_run_fetch(run);
        for (uint i = 0u; i < stp_run_count(r); i++) {
            ivec2 pixel;
            uint bits;
            bool drawn = stp_scatter_place(r, stp_run_sample(r, i).texel, pixel, bits);
#if STP_PLACES
            imageStore(place_image, int(first_place + stp_run_place(run, i)),
                       uvec4(drawn ? uint(pixel.x | pixel.y << 16) : NOT_DRAWN, bits, 0u, 0u));
#endif
            if (drawn &&
                imageLoad(nearest_depth, pixel).x < bits && imageAtomicMax(nearest_depth, pixel, bits) < bits && !first)
                imageStore(nearest_sample, pixel, uvec4(RAISED));
        }
    }
}
