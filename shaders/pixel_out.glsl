// The targets of resolve, pull and push. Needs pixel.glsl.
layout(location = 0) out uvec4 out_shape;
layout(location = 1) out uvec4 out_paint;

void stp_pixel_write(stp_pixel p)
{
    uint blue = uint(clamp(p.colour.b, 0.0, 1.0) * 65535.0 + 0.5);
    out_shape = uvec4(stp_direction_pack(p.normal), floatBitsToUint(p.radius),
                      floatBitsToUint(p.z_min), floatBitsToUint(p.z_max));
    out_paint = uvec4(floatBitsToUint(p.d), packUnorm2x16(p.colour.rg), blue | uint(p.tag) << 16);
}
