// Push, coarse to fine, as push.frag but in place: a pulled pixel stays in the texture unless it is
// pushed. Reads level l as fine and the finished level l + 1 as coarse. Only a pixel's own
// invocation reads it as fine, before writing it.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#define STP_PIXEL_IMAGES
#include "pixel.glsl"
#include "ellipse.glsl"
#include "blend.glsl"
#include "push.glsl"

layout(rgba32ui, binding = 0) writeonly uniform uimage2D shape;
layout(rgba32ui, binding = 1) writeonly uniform uimage2D paint;

struct stp_made {
    uvec4 shape;
    uvec4 paint;
};

stp_made stp_make(stp_pixel p, ivec2 here)
{
    return stp_made(stp_pixel_shape(p), stp_pixel_paint(p));
}

void stp_put_one(ivec2 here, stp_made made, bool wanted)
{
    if (!wanted)
        return;
    imageStore(shape, here, made.shape);
    imageStore(paint, here, made.paint);
}

void stp_put(ivec2 here, stp_made made, stp_made right, stp_made above, stp_made beyond, bvec4 wanted)
{
    stp_put_one(here, made, wanted.x);
    stp_put_one(here + ivec2(1, 0), right, wanted.y);
    stp_put_one(here + ivec2(0, 1), above, wanted.z);
    stp_put_one(here + ivec2(1, 1), beyond, wanted.w);
}

#define STP_COLUMNS_IN_PLACE 1
#include "blocks.glsl"
#include "columns.glsl"
