// Coarse to fine, as push.frag, in place: what was pulled stays in the texture where nothing is pushed over it. Reads
// level l as fine and the finished level l + 1 as coarse; a pixel's own is read before it is written, and by none else.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "blend.glsl"
#include "push.glsl"

layout(rgba32ui, binding = 0) writeonly uniform uimage2D shape;
layout(rgba32ui, binding = 1) writeonly uniform uimage2D paint;

void stp_put_one(ivec2 here, stp_pixel p, bool wanted)
{
    if (!wanted)
        return;
    imageStore(shape, here, stp_pixel_shape(p));
    imageStore(paint, here, stp_pixel_paint(p));
}

void stp_put(ivec2 here, stp_pixel p, stp_pixel right, stp_pixel below, stp_pixel beyond, bvec4 wanted)
{
    stp_put_one(here, p, wanted.x);
    stp_put_one(here + ivec2(1, 0), right, wanted.y);
    stp_put_one(here + ivec2(0, 1), below, wanted.z);
    stp_put_one(here + ivec2(1, 1), beyond, wanted.w);
}

#define STP_COLUMNS_IN_PLACE 1
#include "blocks.glsl"
#include "columns.glsl"
