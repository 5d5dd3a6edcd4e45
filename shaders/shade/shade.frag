// Shades level 0 as resolved, if nothing is reconstructed.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "palette.glsl"
#include "pixel.glsl"
#include "height.glsl"
#include "contour.glsl"
#include "shade.glsl"

layout(location = 0) out vec4 picture;
layout(location = 1) out float depth; // z_min, 0 where empty
#if STP_FADE
layout(location = 2) out uint mark;
#endif

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    stp_pixel p = stp_pixel_fine(here);
    picture = stp_shade_rounded(p, gl_FragCoord.xy);
    depth = p.z_min;
#if STP_FADE
    mark = uint(stp_tag_mark(p.tag));
#endif
#if STP_CONTOURS
    vec3 n = stp_shade_normal(p, -stp_ray(gl_FragCoord.xy));
    imageStore(picture_steps, ivec2(gl_FragCoord.xy), stp_contour_steps(p, n, gl_FragCoord.xy));
#endif
}
