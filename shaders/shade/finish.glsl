// Finishes a pixel: by push, by templates or by splatting. Needs layout.glsl, project.glsl,
// pixel.glsl, ellipse.glsl, blend.glsl.
#include "push.glsl"
#include "template.glsl"
#include "splat_mean.glsl"
#include "splat_sum.glsl"

stp_pixel stp_finish(ivec2 here)
{
#if STP_SPLAT
    return stp_splat_sum(here);
#elif STP_TEMPLATE
    return stp_template(here);
#else
    return stp_push(here);
#endif
}
