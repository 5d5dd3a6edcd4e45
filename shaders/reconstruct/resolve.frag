// Turns the nearest sample of each pixel into level 0 of the pyramid ("Projection" in README.md). With
// STP_SQUARES: only where that is a square of a grid.
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
#include "sample_pixel.glsl"

layout(binding = 8) uniform usampler2D nearest_sample;

layout(location = 6) uniform bool first_pass; // of this frame

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
    if (name == STP_NO_SAMPLE)
        p = stp_pixel_invalid();
    stp_pixel_write(p);
}
