// The targets of resolve, pull and push. Needs pixel.glsl.
layout(location = 0) out vec4 out_shape;
layout(location = 1) out vec4 out_depth;
layout(location = 2) out vec4 out_colour;

void stp_pixel_write(stp_pixel p)
{
    out_shape = vec4(p.normal, p.radius);
    out_depth = vec4(p.z_min, p.z_max, p.d);
    out_colour = vec4(p.colour, float(p.tag));
}
