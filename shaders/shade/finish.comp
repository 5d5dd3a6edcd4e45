// Does the last push and the shading at once, as finish.frag does.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "palette.glsl"
#define STP_PIXEL_IMAGES
#include "pixel.glsl"
#include "ellipse.glsl"
#include "blend.glsl"
#include "push.glsl"
#include "height.glsl"
#include "contour.glsl"
#include "shade.glsl"

layout(r32ui, binding = 0) writeonly uniform uimage2D picture; // RGBA8
layout(r32f, binding = 1) writeonly uniform image2D depth;     // z_min, 0 where empty
#if STP_FADE
layout(r8ui, binding = 2) writeonly uniform uimage2D mark;
#endif

struct stp_made {
    uint picture;
    float depth;
    uint mark;
    vec4 steps; // stp_contour_steps
};

stp_made stp_make(stp_pixel p, ivec2 here)
{
    vec2 window = vec2(here) + 0.5;
#if STP_CONTOURS
    vec4 steps = stp_contour_steps(p, stp_shade_normal(p, -stp_ray(window)), window);
#else
    vec4 steps = vec4(0.0);
#endif
    return stp_made(packUnorm4x8(stp_shade(p, window)), p.z_min, uint(stp_tag_mark(p.tag)), steps);
}

void stp_put_picture(ivec2 here, stp_made made, bool wanted)
{
    if (wanted)
        imageStore(picture, here, uvec4(made.picture));
}

void stp_put_rest(ivec2 here, stp_made made, bool wanted)
{
    if (!wanted)
        return;
    imageStore(depth, here, vec4(made.depth));
#if STP_FADE
    imageStore(mark, here, uvec4(made.mark));
#endif
#if STP_CONTOURS
    imageStore(picture_steps, here, made.steps);
#endif
}

// Writes image by image: alternating stores to several images cost a software driver twice as much.
void stp_put(ivec2 here, stp_made made, stp_made right, stp_made above, stp_made beyond, bvec4 wanted)
{
    stp_put_picture(here, made, wanted.x);
    stp_put_picture(here + ivec2(1, 0), right, wanted.y);
    stp_put_picture(here + ivec2(0, 1), above, wanted.z);
    stp_put_picture(here + ivec2(1, 1), beyond, wanted.w);
    stp_put_rest(here, made, wanted.x);
    stp_put_rest(here + ivec2(1, 0), right, wanted.y);
    stp_put_rest(here + ivec2(0, 1), above, wanted.z);
    stp_put_rest(here + ivec2(1, 1), beyond, wanted.w);
}

#define STP_COLUMNS_IN_PLACE 0
#include "blocks.glsl"
#include "columns.glsl"
