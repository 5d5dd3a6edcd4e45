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
    uint end = stp_end_place();
    for (uint place = stp_first_place(); place < end; place += STP_PLACE_STEP) {
        stp_projected s;
        ivec2 pixel;
        uint bits;
        if (stp_find(place, s) && stp_scatter_place(s, pixel, bits) && imageLoad(nearest_depth, pixel).x < bits &&
            imageAtomicMax(nearest_depth, pixel, bits) < bits && !first)
            imageStore(nearest_sample, pixel, uvec4(RAISED));
    }
}
