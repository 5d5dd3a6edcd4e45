// The render targets of resolve, pull and push. Needs pixel.glsl.
layout(location = 0) out uvec4 out_shape;
layout(location = 1) out uvec4 out_paint;

void stp_pixel_write(stp_pixel p)
{
    out_shape = stp_pixel_shape(p);
    out_paint = stp_pixel_paint(p);
}
