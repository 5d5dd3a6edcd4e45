// Deferred shading of the finished level 0 ("Shading" in README.md). pyramid_level: of the pyramid's
// top, 0 where nothing was reconstructed.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "palette.glsl"
#include "pixel.glsl"

layout(location = 0) out vec4 picture;

vec3 stp_shade_phong(vec3 colour, vec3 n, vec3 v)
{
    vec3 l = normalize(vec3(0.35, 0.45, 1.0));
    vec3 h = normalize(l + v);
    return colour * (0.18 + 0.74 * max(0.0, dot(n, l)) + 0.08 * max(0.0, n.z)) +
           0.16 * pow(max(0.0, dot(n, h)), 40.0);
}

// Where a pixel takes its values from: itself, or a neighbour if no ellipse reached it but three of
// its four neighbours are covered. Such pixels are gaps between samples that averaging opened;
// a gap that the scan has is longer.
ivec2 stp_source_pixel(ivec2 here)
{
    bool left = texelFetch(fine_colour, here - ivec2(1, 0), 0).a != 0.0;
    bool right = texelFetch(fine_colour, here + ivec2(1, 0), 0).a != 0.0;
    bool below = texelFetch(fine_colour, here - ivec2(0, 1), 0).a != 0.0;
    bool above = texelFetch(fine_colour, here + ivec2(0, 1), 0).a != 0.0;
    bool own = texelFetch(fine_colour, here, 0).a != 0.0;
    bool closed = int(left) + int(right) + int(below) + int(above) >= 3;
    return own || !closed ? here : here + ivec2(left ? -1 : 1, 0);
}

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    if (pyramid_level > 0)
        here = stp_source_pixel(here);
    vec4 colour = texelFetch(fine_colour, here, 0);
    picture = vec4(0.0);
    if (colour.a == 0.0)
        return;
    stp_pixel p = stp_pixel_unpack(texelFetch(fine_shape, here, 0), texelFetch(fine_depth, here, 0),
                                   colour);
    vec3 v = -stp_ray(gl_FragCoord.xy);
    vec3 n = stp_tag_two_sided(p.tag) && dot(p.normal, v) < 0.0 ? -p.normal : p.normal;
#if STP_SHADE == STP_SHADE_PHONG
    vec3 c = stp_shade_phong(p.colour, n, v);
#elif STP_SHADE == STP_SHADE_LAMBERT
    vec3 c = p.colour * (0.05 + 0.85 * max(0.0, n.z));
#elif STP_SHADE == STP_SHADE_NORMAL
    vec3 c = n * 0.5 + 0.5;
#elif STP_SHADE == STP_SHADE_DEPTH
    vec3 c = vec3(1.0 - (p.z_min - quality.z) / (quality.w - quality.z));
#elif STP_SHADE == STP_SHADE_CONFIDENCE
    vec3 c = stp_palette_confidence(stp_tag_source(p.tag));
#else
    vec3 c = p.colour; // of level, chunk or error, written at projection
#endif
    picture = vec4(clamp(c, 0.0, 1.0), 1.0);
}
