// Splatting, last step: divides sums by weights, which gives level 0 as finished. Needs pixel.glsl,
// project.glsl.

layout(binding = 8) uniform sampler2D front_end;
layout(binding = 9) uniform sampler2D normal_sum;
layout(binding = 10) uniform sampler2D colour_sum;

// The front sample's pixel, with the means of its surface; a segment or triangle keeps its own
// values.
stp_pixel stp_splat_sum(ivec2 here)
{
    stp_pixel p = stp_pixel_fine(here);
    vec4 normal = texelFetch(normal_sum, here, 0);
    vec4 colour = texelFetch(colour_sum, here, 0) / max(normal.w, 1e-30);
    float norm = dot(normal.xyz, normal.xyz);
    float extent = p.z_max - p.z_min;
    if (p.tag == 0 || normal.w <= 0.0 || stp_tag_polygon(p.tag) || stp_tag_line(p.tag))
        return p;
    p.normal = norm > 0.0 ? normal.xyz * inversesqrt(norm) : p.normal;
    p.colour = colour.rgb;
    float end = stp_depth_decode(texelFetch(front_end, here, 0).x);
    p.z_min = end - colour.a / stp_pixels_per_unit(end);
    p.z_max = p.z_min + extent;
    p.middle = p.z_min;
    p.d = vec2(0.0);
    p.tag = stp_tag_from(p.tag, 1);
    return p;
}
