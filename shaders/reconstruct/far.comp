// Finds, for each pixel of a finished level above 0, the depth beyond which nothing can change it.
// An invocation makes the four pixels of one pixel of the next level.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#define STP_PIXEL_IMAGES
#include "pixel.glsl"
#include "ellipse.glsl"
#include "blend.glsl"
#include "push.glsl"
#include "far.glsl"

layout(location = 7) uniform ivec2 level_size;

layout(rg32f, binding = 0) writeonly uniform image2D far;

// Whether push takes an empty pixel to lie beyond an outline, if not all of the four pixels that it
// reads are valid.
bool stp_far_outline(ivec2 here)
{
    vec2 centre = stp_pixel_centre(here, pyramid_level);
    ivec2 parent = here >> 1, side = 2 * (here & 1) - 1;
    return stp_push_beyond(stp_push_look(parent), centre) &&
           stp_push_beyond(stp_push_look(parent + ivec2(side.x, 0)), centre) &&
           stp_push_beyond(stp_push_look(parent + ivec2(0, side.y)), centre) &&
           stp_push_beyond(stp_push_look(parent + side), centre);
}

// Where the interval of a pixel of the next level ends; without what is invalid; with it.
vec2 stp_far_end(ivec2 p)
{
    float end = stp_far_above(p, read_size).y;
    return vec2(end < STP_FAR_NONE ? end : 0.0, end);
}

// parent: of the pixel above. ends: the last of those of the four pixels that push read.
void stp_far(ivec2 here, float parent, vec2 ends)
{
    int tag = int(imageLoad(fine_paint, here).w >> 16);
    float end = tag == 0 ? STP_FAR_NONE : uintBitsToFloat(imageLoad(fine_shape, here).w);
    float depth = end;
    if (tag != 0 && stp_tag_source(tag) != pyramid_level) {
        depth = max(end, max(parent, ends.x));
        if (depth < STP_FAR_NONE && ends.y >= STP_FAR_NONE && stp_far_outline(here))
            depth = STP_FAR_NONE;
    }
    imageStore(far, here, vec4(depth, end, 0.0, 0.0));
}

void main()
{
    ivec2 above = ivec2(gl_GlobalInvocationID.xy), here = 2 * above;
    if (any(greaterThanEqual(here, level_size)))
        return;
    vec2 left[3], right[3];
    for (int i = 0; i < 3; i++) {
        ivec2 p = above + ivec2(0, i - 1);
        vec2 middle = stp_far_end(p);
        left[i] = max(middle, stp_far_end(p - ivec2(1, 0)));
        right[i] = max(middle, stp_far_end(p + ivec2(1, 0)));
    }
    float parent = stp_far_above(above, read_size).x;
    stp_far(here, parent, max(left[0], left[1]));
    stp_far(here + ivec2(1, 0), parent, max(right[0], right[1]));
    stp_far(here + ivec2(0, 1), parent, max(left[1], left[2]));
    stp_far(here + ivec2(1, 1), parent, max(right[1], right[2]));
}
