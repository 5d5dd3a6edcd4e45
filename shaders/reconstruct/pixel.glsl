// A pixel of the pyramid: its members and their packing ("A pixel of the pyramid" in README.md).

struct stp_pixel {
    vec3 normal;   // eye space
    float radius;  // world units
    float z_min;   // depth interval
    float z_max;
    vec2 d;        // centre of the ellipse minus the pixel's centre, viewport pixels
    vec3 colour;
    float middle;  // depth of the surface at the ellipse's centre; without STP_HEIGHTS not kept
    int tag;       // 0: invalid; else 1 + kind + 8 two_sided + 16 source + 512 mark
};

#define STP_KIND_RIBBON 1
#define STP_KIND_TUBE 2
#define STP_KIND_POLYGON 3

// A pixel is two RGBA32UI texels, since fetches are the cost of pull and push. `paint` alone is
// enough to shade a pixel and to know whether another is in front of it.
//   shape: d, radius, z_max (32-bit floats; with STP_HEIGHTS the last bytes of d.x and d.y, low and high, are where middle
//          lies between z_min and z_max, in 1/65535)
//   paint: normal (octahedral, 2 x 16 bits), z_min (32-bit float), red | green << 16, blue | tag << 16 (16-bit fractions
//          of 1)
// Compute shaders load images: a software driver inlines loads, but calls functions for fetches.
#ifdef STP_PIXEL_IMAGES
layout(rgba32ui, binding = 4) readonly uniform uimage2D fine_shape;
layout(rgba32ui, binding = 5) readonly uniform uimage2D fine_paint;
layout(rgba32ui, binding = 6) readonly uniform uimage2D coarse_shape;
layout(rgba32ui, binding = 7) readonly uniform uimage2D coarse_paint;
#define STP_FETCH(texels, p) imageLoad(texels, p)
#else
layout(binding = 4) uniform usampler2D fine_shape;
layout(binding = 5) uniform usampler2D fine_paint;
layout(binding = 6) uniform usampler2D coarse_shape;
layout(binding = 7) uniform usampler2D coarse_paint;
#define STP_FETCH(texels, p) texelFetch(texels, p, 0)
#endif

// Size of the level that is read (pull: fine, push: coarse).
layout(location = 3) uniform ivec2 read_size;

bool stp_inside(ivec2 p)
{
    return all(lessThan(uvec2(p), uvec2(read_size))); // negative ones become large
}

uint stp_direction_pack(vec3 n)
{
    vec2 e = n.xy / max(abs(n.x) + abs(n.y) + abs(n.z), 1e-30);
    vec2 folded = (1.0 - abs(e.yx)) * vec2(e.x >= 0.0 ? 1.0 : -1.0, e.y >= 0.0 ? 1.0 : -1.0);
    return packSnorm2x16(n.z < 0.0 ? folded : e);
}

vec3 stp_direction_unpack(uint code)
{
    // unpackSnorm2x16() without its clamp: -32768 is never packed.
    vec2 e = vec2(ivec2(int(code << 16), int(code)) >> 16) * (1.0 / 32767.0);
    float z = 1.0 - abs(e.x) - abs(e.y);
    float fold = max(-z, 0.0);
    vec3 n = vec3(e.x + (e.x >= 0.0 ? -fold : fold), e.y + (e.y >= 0.0 ? -fold : fold), z);
    return n * inversesqrt(dot(n, n));
}

stp_pixel stp_pixel_unpack(uvec4 shape, uvec4 paint)
{
    float z_min = uintBitsToFloat(paint.y), z_max = uintBitsToFloat(shape.w), middle = z_min;
#if STP_HEIGHTS
    middle = mix(z_min, z_max, float(shape.x & 255u | (shape.y & 255u) << 8) * (1.0 / 65535.0));
    shape.xy &= ~255u;
#endif
    return stp_pixel(stp_direction_unpack(paint.x), uintBitsToFloat(shape.z), z_min, z_max, uintBitsToFloat(shape.xy),
                     vec3(uvec3(paint.z & 65535u, paint.z >> 16, paint.w & 65535u)) * (1.0 / 65535.0), middle,
                     int(paint.w >> 16));
}

uvec4 stp_pixel_shape(stp_pixel p)
{
    uvec2 d = floatBitsToUint(p.d);
#if STP_HEIGHTS
    float share = (p.middle - p.z_min) / max(p.z_max - p.z_min, 1e-30);
    uint middle = uint(clamp(share, 0.0, 1.0) * 65535.0 + 0.5);
    d = (d + 128u & ~255u) | uvec2(middle & 255u, middle >> 8);
#endif
    return uvec4(d, floatBitsToUint(p.radius), floatBitsToUint(p.z_max));
}

uvec4 stp_pixel_paint(stp_pixel p)
{
    uint blue = uint(clamp(p.colour.b, 0.0, 1.0) * 65535.0 + 0.5);
    return uvec4(stp_direction_pack(p.normal), floatBitsToUint(p.z_min), packUnorm2x16(p.colour.rg),
                 blue | uint(p.tag) << 16);
}

stp_pixel stp_pixel_fine(ivec2 p)
{
    return stp_pixel_unpack(STP_FETCH(fine_shape, p), STP_FETCH(fine_paint, p));
}

stp_pixel stp_pixel_coarse(ivec2 p)
{
    return stp_pixel_unpack(STP_FETCH(coarse_shape, p), STP_FETCH(coarse_paint, p));
}

stp_pixel stp_pixel_invalid()
{
    return stp_pixel(vec3(0.0), 0.0, 0.0, 0.0, vec2(0.0), vec3(0.0), 0.0, 0);
}

bool stp_tag_two_sided(int tag)
{
    return ((tag - 1) & 8) != 0;
}

// A tube's normal is its tangent, and its disc faces the eye (MKC08, section 4.2). False if there
// are no lines.
bool stp_tag_tube(int tag)
{
    return STP_LINES != 0 && tag != 0 && ((tag - 1) & 3) == STP_KIND_TUBE;
}

bool stp_tag_line(int tag)
{
    int kind = (tag - 1) & 3;
    return STP_LINES != 0 && tag != 0 && (kind == STP_KIND_TUBE || kind == STP_KIND_RIBBON);
}

bool stp_tag_polygon(int tag)
{
    return STP_TRIANGLES != 0 && tag != 0 && ((tag - 1) & 3) == STP_KIND_POLYGON;
}

// The pyramid level that the pixel's values come from; 0: measured.
int stp_tag_source(int tag)
{
    return (tag - 1) >> 4 & 15;
}

// The mark that fade.frag compares between frames; 0 if the variant does not fade.
int stp_tag_mark(int tag)
{
    return tag >> 9;
}

int stp_tag_from(int tag, int source)
{
    return 1 + ((tag - 1) & 15) + 16 * source + (tag & ~511);
}

// Centre of pixel p of a level, viewport pixels.
vec2 stp_pixel_centre(ivec2 p, int level)
{
    return (vec2(p) + 0.5) * float(1 << level);
}
