// The last push and the shading at once, as finish.frag.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "palette.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "blend.glsl"
#include "push.glsl"
#include "shade.glsl"

layout(rgba8, binding = 0) writeonly uniform image2D picture;
layout(r32f, binding = 1) writeonly uniform image2D depth; // z_min, 0 where nothing is
#if STP_FADE
layout(r8ui, binding = 2) writeonly uniform uimage2D mark;
#endif

void stp_put_picture(ivec2 here, vec4 colour, bool wanted)
{
    if (wanted)
        imageStore(picture, here, colour);
}

void stp_put_rest(ivec2 here, stp_pixel p, bool wanted)
{
    if (!wanted)
        return;
    imageStore(depth, here, vec4(p.z_min));
#if STP_FADE
    imageStore(mark, here, uvec4(stp_tag_mark(p.tag)));
#endif
}

// What goes to one image is written at once: stores by turns to several cost a software driver twice as much.
void stp_put(ivec2 here, stp_pixel p, stp_pixel right, stp_pixel below, stp_pixel beyond, bvec4 wanted)
{
    vec2 window = vec2(here) + 0.5;
    vec4 c0 = stp_shade(p, window), c1 = stp_shade(right, window + vec2(1.0, 0.0));
    vec4 c2 = stp_shade(below, window + vec2(0.0, 1.0)), c3 = stp_shade(beyond, window + 1.0);
    stp_put_picture(here, c0, wanted.x);
    stp_put_picture(here + ivec2(1, 0), c1, wanted.y);
    stp_put_picture(here + ivec2(0, 1), c2, wanted.z);
    stp_put_picture(here + ivec2(1, 1), c3, wanted.w);
    stp_put_rest(here, p, wanted.x);
    stp_put_rest(here + ivec2(1, 0), right, wanted.y);
    stp_put_rest(here + ivec2(0, 1), below, wanted.z);
    stp_put_rest(here + ivec2(1, 1), beyond, wanted.w);
}

#define STP_COLUMNS_IN_PLACE 0
#include "blocks.glsl"
#include "columns.glsl"
