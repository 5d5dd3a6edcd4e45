// Finds, for each cell of 8 x 8 pixels of the picture, the depth beyond which nothing can change it.
#include "far.glsl"

layout(r32f, binding = 0) writeonly uniform image2D far;
layout(r32f, binding = 2) readonly uniform image2D picture_depth; // 0 where empty

layout(location = 2) uniform int pyramid_level; // how many levels there are above the picture
layout(location = 3) uniform ivec2 read_size;   // of level 1
layout(location = 7) uniform ivec2 level_size;  // of the picture

void main()
{
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy), last = level_size - 1;
    float near = STP_FAR_NONE, depth = 0.0;
    if (any(greaterThan(8 * cell, last)))
        return;
    for (int i = 0; i < 64; i++) {
        float here = imageLoad(picture_depth, min(8 * cell + ivec2(i & 7, i >> 3), last)).x;
        depth = max(depth, here);
        near = min(near, here);
    }
    depth = near > 0.0 ? depth : STP_FAR_NONE;
    for (int y = -1; y < 5 && pyramid_level > 0; y++)
        for (int x = -1; x < 5; x++)
            depth = max(depth, stp_far_above(4 * cell + ivec2(x, y), read_size).y);
    for (int i = 0; i < 16 && pyramid_level > 0; i++) {
        ivec2 parent = min(4 * cell + ivec2(i & 3, i >> 2), read_size - 1);
        depth = max(depth, stp_far_above(parent, read_size).x);
    }
    imageStore(far, cell, vec4(depth));
}
