// Pulls two levels at once, as pull.frag does one after the other; without templates. For each of
// its pixels of level l + 1, an invocation makes the four pixels of level l under it, then the
// pixel itself from these four as stored. Reads level l - 1 as fine.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#define STP_PIXEL_IMAGES
#include "pixel.glsl"
#include "ellipse.glsl"
#include "blend.glsl"
#include "pull.glsl"
#include "blocks.glsl"

layout(rgba32ui, binding = 0) writeonly uniform uimage2D shape;
layout(rgba32ui, binding = 1) writeonly uniform uimage2D paint;
layout(rgba32ui, binding = 2) writeonly uniform uimage2D shape_above;
layout(rgba32ui, binding = 3) writeonly uniform uimage2D paint_above;

struct stp_texel {
    uvec4 shape;
    uvec4 paint;
};

stp_texel stp_texel_of(stp_pixel p)
{
    return stp_texel(stp_pixel_shape(p), stp_pixel_paint(p));
}

void main()
{
    uvec2 block = stp_block();
    ivec2 size = (read_size + 1) >> 1; // of level l
    for (int i = 0; i < STP_BLOCK_SIZE.x / STP_BLOCK_LANES * STP_BLOCK_SIZE.y; i++) {
        ivec2 in_block = ivec2((i & 1) * STP_BLOCK_LANES + int(gl_LocalInvocationID.x), i >> 1);
        ivec2 above = stp_block_place(block) + in_block;
        if (!stp_block_wants(block, in_block))
            continue;
        ivec2 here = 2 * above;
        stp_texel t0 = stp_texel_of(stp_pull_fine(here, pyramid_level));
        stp_texel t1 = stp_texel_of(stp_pull_fine(here + ivec2(1, 0), pyramid_level));
        stp_texel t2 = stp_texel_of(stp_pull_fine(here + ivec2(0, 1), pyramid_level));
        stp_texel t3 = stp_texel_of(stp_pull_fine(here + ivec2(1, 1), pyramid_level));
        imageStore(shape, here, t0.shape);
        imageStore(shape, here + ivec2(1, 0), t1.shape);
        imageStore(shape, here + ivec2(0, 1), t2.shape);
        imageStore(shape, here + ivec2(1, 1), t3.shape);
        imageStore(paint, here, t0.paint);
        imageStore(paint, here + ivec2(1, 0), t1.paint);
        imageStore(paint, here + ivec2(0, 1), t2.paint);
        imageStore(paint, here + ivec2(1, 1), t3.paint);
        stp_texel t = stp_texel_of(stp_pull(above, pyramid_level + 1, size, stp_pixel_unpack(t0.shape, t0.paint),
                                            stp_pixel_unpack(t1.shape, t1.paint), stp_pixel_unpack(t2.shape, t2.paint),
                                            stp_pixel_unpack(t3.shape, t3.paint)));
        imageStore(shape_above, above, t.shape);
        imageStore(paint_above, above, t.paint);
    }
}
