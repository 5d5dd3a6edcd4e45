// Turns the nearest sample of each pixel into level 0 of the pyramid ("Projection" in README.md). With
// STP_SQUARES: only where that is a square of a grid or a map.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "choose.glsl"
#include "palette.glsl"
#include "pixel.glsl"
#include "pixel_out.glsl"
#include "ellipse.glsl"
#include "square.glsl"
#include "shape.glsl"
#include "map.glsl"
#include "sample_pixel.glsl"
#if STP_SQUARES && STP_MAPS == STP_MAPS_BLEND
#include "splat_bins.glsl"
#include "splat_gather.glsl"
#include "splat_add.glsl"
#include "splat_mean.glsl"
#endif

layout(binding = 8) uniform usampler2D nearest_sample;

layout(location = 6) uniform bool first_pass; // of this frame

#if STP_SQUARES && STP_MAPS == STP_MAPS_BLEND
// The mean of the splats no farther than the interval of the front's pixel.
stp_pixel stp_map_blend(stp_pixel front, ivec2 here)
{
    stp_splat_pixel sums = stp_splat_begin(here, front.z_max);
    stp_splat_walk(sums, here);
    return stp_splat_mean(front, sums.normal / STP_SPLAT_STEPS, sums.colour / STP_SPLAT_STEPS, front.z_max);
}
#endif

void main()
{
    uint name = texelFetch(nearest_sample, ivec2(gl_FragCoord.xy), 0).x;
    bool square = (name & ~STP_NAME_SAMPLE) == STP_NAME_SQUARE;
#if STP_SQUARES
    if (!square)
        discard;
#else
    name = square ? STP_NO_SAMPLE : name; // the program for squares comes next
    if (name == STP_NO_SAMPLE && !first_pass) // an earlier pass may have drawn the pixel
        discard;
#endif
    stp_pixel p = stp_sample_pixel(name, gl_FragCoord.xy);
#if STP_SQUARES && STP_MAPS == STP_MAPS_BLEND
    if ((name & STP_SQUARE_SPLAT) != 0u)
        p = stp_map_blend(p, ivec2(gl_FragCoord.xy));
#endif
#if STP_SQUARES && STP_MAPS
    if ((name & (STP_SQUARE_SPLAT | STP_SQUARE_BORDER)) == STP_SQUARE_SPLAT)
        p.radius = 0.0;
#endif
    if (name == STP_NO_SAMPLE)
        p = stp_pixel_invalid();
    stp_pixel_write(p);
}
