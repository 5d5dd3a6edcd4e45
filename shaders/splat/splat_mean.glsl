// Splatting: a front sample's pixel with the means of its surface. Needs pixel.glsl, project.glsl.

// normal, colour: the sums of stp_splat_pixel. end: of the front's interval.
stp_pixel stp_splat_mean(stp_pixel p, vec4 normal, vec4 colour, float end)
{
    float norm = dot(normal.xyz, normal.xyz), extent = p.z_max - p.z_min;
    colour /= max(normal.w, 1e-30);
    p.normal = norm > 0.0 ? normal.xyz * inversesqrt(norm) : p.normal;
    p.colour = colour.rgb;
    p.z_min = end - colour.a / stp_pixels_per_unit(end);
    p.z_max = p.z_min + extent;
    p.middle = p.z_min;
    p.d = vec2(0.0);
    p.tag = stp_tag_from(p.tag, 1);
    return p;
}
