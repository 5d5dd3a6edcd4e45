// Finds, for each pixel of a finished level above 0, the depth beyond which nothing can change it.
// An invocation makes the four pixels of one pixel of the next level.
#include "layout.glsl"
#define STP_PIXEL_IMAGES
#include "pixel.glsl"
#include "far.glsl"

layout(location = 7) uniform ivec2 level_size;

void stp_far(ivec2 here, float pushed)
{
    int tag = int(imageLoad(fine_paint, here).w >> 16);
    float own = uintBitsToFloat(imageLoad(fine_shape, here).w);
    float depth = stp_tag_source(tag) == pyramid_level ? own : max(own, pushed);
    imageStore(far, here, vec4(tag == 0 ? STP_FAR_NONE : depth));
}

void main()
{
    ivec2 above = ivec2(gl_GlobalInvocationID.xy), here = 2 * above;
    if (any(greaterThanEqual(here, level_size)))
        return;
    float left[3], right[3];
    for (int i = 0; i < 3; i++) {
        ivec2 p = above + ivec2(0, i - 1);
        float middle = stp_far_above(p, read_size);
        left[i] = max(middle, stp_far_above(p - ivec2(1, 0), read_size));
        right[i] = max(middle, stp_far_above(p + ivec2(1, 0), read_size));
    }
    stp_far(here, max(left[0], left[1]));
    stp_far(here + ivec2(1, 0), max(right[0], right[1]));
    stp_far(here + ivec2(0, 1), max(left[1], left[2]));
    stp_far(here + ivec2(1, 1), max(right[1], right[2]));
}
