// A pixel of the pyramid, in three float targets (shaders/README.md).

struct stp_pixel {
    vec3 normal;   // eye space
    float radius;  // world units
    float z_min;   // depth interval
    float z_max;
    vec2 d;        // centre of the ellipse minus the pixel's centre, viewport pixels
    vec3 colour;
    int tag;       // 0: invalid; else 1 + kind + 8 two_sided + 16 source
};

layout(binding = 3) uniform sampler2D fine_shape;
layout(binding = 4) uniform sampler2D fine_depth;
layout(binding = 5) uniform sampler2D fine_colour;
layout(binding = 6) uniform sampler2D coarse_shape;
layout(binding = 7) uniform sampler2D coarse_depth;
layout(binding = 8) uniform sampler2D coarse_colour;

stp_pixel stp_pixel_unpack(vec4 shape, vec4 depth, vec4 colour)
{
    return stp_pixel(shape.xyz, shape.w, depth.x, depth.y, depth.zw, colour.rgb, int(colour.a));
}

stp_pixel stp_pixel_invalid()
{
    return stp_pixel(vec3(0.0), 0.0, 0.0, 0.0, vec2(0.0), vec3(0.0), 0);
}

bool stp_tag_two_sided(int tag)
{
    return ((tag - 1) & 8) != 0;
}

// The pyramid level the values come from: 0 is a measured pixel.
int stp_tag_source(int tag)
{
    return (tag - 1) >> 4;
}

int stp_tag_from(int tag, int source)
{
    return 1 + ((tag - 1) & 15) + 16 * source;
}

// Centre of pixel p of a level, viewport pixels.
vec2 stp_pixel_centre(ivec2 p, int level)
{
    return (vec2(p) + 0.5) * float(1 << level);
}
