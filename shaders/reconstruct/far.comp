// Finds, for each pixel of a finished level above 0, the depth beyond which nothing can change it.
// An invocation makes the four pixels of one pixel of the next level.
#include "layout.glsl"
#define STP_PIXEL_IMAGES
#include "pixel.glsl"
#include "far.glsl"

layout(location = 7) uniform ivec2 level_size;

layout(rg32f, binding = 0) writeonly uniform image2D far;

// pushed: what push read of the next level.
void stp_far(ivec2 here, float pushed)
{
    int tag = int(imageLoad(fine_paint, here).w >> 16);
    float end = tag == 0 ? STP_FAR_NONE : uintBitsToFloat(imageLoad(fine_shape, here).w);
    imageStore(far, here, vec4(stp_tag_source(tag) == pyramid_level ? end : max(end, pushed), end, 0.0, 0.0));
}

void main()
{
    ivec2 above = ivec2(gl_GlobalInvocationID.xy), here = 2 * above;
    if (any(greaterThanEqual(here, level_size)))
        return;
    float left[3], right[3];
    for (int i = 0; i < 3; i++) {
        ivec2 p = above + ivec2(0, i - 1);
        float middle = stp_far_above(p, read_size).y;
        left[i] = max(middle, stp_far_above(p - ivec2(1, 0), read_size).y);
        right[i] = max(middle, stp_far_above(p + ivec2(1, 0), read_size).y);
    }
    float parent = stp_far_above(above, read_size).x;
    stp_far(here, max(parent, max(left[0], left[1])));
    stp_far(here + ivec2(1, 0), max(parent, max(right[0], right[1])));
    stp_far(here + ivec2(0, 1), max(parent, max(left[1], left[2])));
    stp_far(here + ivec2(1, 1), max(parent, max(right[1], right[2])));
}
