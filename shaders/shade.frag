// Deferred shading of the finished level 0 ("Shading" in README.md).
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

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec4 colour = texelFetch(fine_colour, here, 0);
    picture = vec4(0.0);
    if (colour.a == 0.0)
        return;
    stp_pixel p = stp_pixel_unpack(texelFetch(fine_shape, here, 0), texelFetch(fine_depth, here, 0),
                                   colour);
    vec3 v = -stp_ray(vec2(here) + 0.5);
    vec3 n = stp_tag_two_sided(p.tag) && dot(p.normal, v) < 0.0 ? -p.normal : p.normal;
    vec3 c = p.colour;
    if (modes.y == STP_SHADE_PHONG)
        c = stp_shade_phong(p.colour, n, v);
    else if (modes.y == STP_SHADE_LAMBERT)
        c = p.colour * (0.05 + 0.85 * max(0.0, n.z));
    else if (modes.y == STP_SHADE_NORMAL)
        c = n * 0.5 + 0.5;
    else if (modes.y == STP_SHADE_DEPTH)
        c = vec3(1.0 - (p.z_min - quality.z) / (quality.w - quality.z));
    else if (modes.y == STP_SHADE_CONFIDENCE)
        c = stp_palette_confidence(stp_tag_source(p.tag));
    picture = vec4(clamp(c, 0.0, 1.0), 1.0);
}
