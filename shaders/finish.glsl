// A finished pixel, by push or by templates. Needs layout.glsl, project.glsl, pixel.glsl, ellipse.glsl, blend.glsl.
#include "push.glsl"
#include "template.glsl"

stp_pixel stp_finish(ivec2 here)
{
#if STP_TEMPLATE
    return stp_template(here);
#else
    return stp_push(here);
#endif
}
