// Splatting, last step: divides sums by weights, which gives level 0 as finished. Needs pixel.glsl,
// project.glsl, splat_mean.glsl.

layout(binding = 8) uniform sampler2D front_end;
layout(binding = 9) uniform sampler2D normal_sum;
layout(binding = 10) uniform sampler2D colour_sum;

// The front sample's pixel, with the means of its surface; a segment or triangle keeps its own
// values.
stp_pixel stp_splat_sum(ivec2 here)
{
    stp_pixel p = stp_pixel_fine(here);
    vec4 normal = texelFetch(normal_sum, here, 0);
    if (p.tag == 0 || normal.w <= 0.0 || stp_tag_polygon(p.tag) || stp_tag_line(p.tag))
        return p;
    return stp_splat_mean(p, normal, texelFetch(colour_sum, here, 0), stp_depth_decode(texelFetch(front_end, here, 0).x));
}
