// The depth beyond which nothing can change a pixel ("Occlusion" in README.md), one level after the
// other. Images, since a software driver inlines loads, but calls functions for fetches.
#define STP_FAR_NONE 1e38

layout(local_size_x = 8, local_size_y = 8) in;

layout(r32f, binding = 0) writeonly uniform image2D far;
layout(r32f, binding = 1) readonly uniform image2D far_above; // of the next level

float stp_far_above(ivec2 p, ivec2 size)
{
    return all(lessThan(uvec2(p), uvec2(size))) ? imageLoad(far_above, p).x : STP_FAR_NONE;
}
