// The depth beyond which nothing can change a pixel ("Occlusion" in README.md), one level after the
// other. Images, since a software driver inlines loads, but calls functions for fetches.
#define STP_FAR_NONE 1e38

layout(local_size_x = 8, local_size_y = 8) in;

// The next level's pixels: nothing behind the first depth can change the pixel; its interval ends
// at the second.
layout(rg32f, binding = 1) readonly uniform image2D far_above;

// Beyond the border push reads the pixel mirrored there.
vec2 stp_far_above(ivec2 p, ivec2 size)
{
    p = abs(min(p, 2 * size - 2 - p));
    return all(lessThan(uvec2(p), uvec2(size))) ? imageLoad(far_above, p).xy : vec2(STP_FAR_NONE);
}
