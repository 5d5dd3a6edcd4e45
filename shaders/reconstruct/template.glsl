// Templates (Mar08, section 6) replace push: each pixel of level 0 searches every level for
// ellipses that cover the pixel, in a window of STP_TEMPLATE x STP_TEMPLATE pixels ("Templates" in
// README.md). Needs layout.glsl, project.glsl, pixel.glsl, ellipse.glsl, blend.glsl.

#if STP_TEMPLATE

// Whether a pixel goes on to the next level, since its ellipse is too wide for this level's
// windows.
bool stp_template_carries(stp_pixel p, int level)
{
    return 2.0 * stp_ellipse_radius_px(p) > float((STP_TEMPLATE - 1) << level);
}

// The shape of the pulled pixel `at` of a level.
uvec4 stp_template_shape(ivec2 at, int level)
{
    return level == 0 ? texelFetch(fine_shape, at, 0) : texelFetch(coarse_shape, at, level - 1);
}

stp_pixel stp_template_pulled(ivec2 at, int level)
{
    uvec4 paint = level == 0 ? texelFetch(fine_paint, at, 0) : texelFetch(coarse_paint, at, level - 1);
    return stp_pixel_unpack(stp_template_shape(at, level), paint);
}

// Whether a pixel is searched on this level: it goes no further, or was left behind a nearer pixel.
bool stp_template_lives(stp_pixel p, ivec2 at, int level)
{
    if (level == pyramid_level)
        return true;
    float parent_z_max = uintBitsToFloat(stp_template_shape(at >> 1, level + 1).w);
    return !stp_template_carries(p, level) || p.z_min > parent_z_max;
}

// An ellipse as seen from a point.
struct stp_template_hit {
    stp_pixel pixel; // z_min, z_max, middle: where the ray meets its disc
    float q;
};

// If no ellipse covers a pixel, the nearest one still counts if ellipses come near on three sides
// up to the first of these q, or on four sides up to the second: merging opens gaps that no surface
// has.
#define STP_TEMPLATE_GAP_3 3.0
#define STP_TEMPLATE_GAP_4 6.0

struct stp_template_gap {
    uvec2 sides;   // bit sets of quadrants: with an ellipse up to STP_TEMPLATE_GAP_3, up to _4
    float q;       // the least of all
    ivec3 nearest; // pixel and level
};

// Adds an ellipse to the gap if it comes near.
void stp_template_miss(inout stp_template_gap gap, stp_template_hit hit, ivec2 at, int level)
{
    if (hit.q > STP_TEMPLATE_GAP_4 || hit.pixel.tag == 0)
        return;
    vec2 d = hit.pixel.d;
    uint side = 1u << (uint(d.x > 0.0) + 2u * uint(d.y > 0.0));
    gap.sides |= uvec2(hit.q <= STP_TEMPLATE_GAP_3 ? side : 0u, side);
    if (hit.q < gap.q) {
        gap.q = hit.q;
        gap.nearest = ivec3(at, level);
    }
}

// The ellipse of pulled pixel c, `at` of a level, seen from pixel `here` of level 0. The pixel's
// own ellipse always counts as covering it.
stp_template_hit stp_template_look(stp_pixel c, ivec2 here, ivec2 at, int level, vec3 ray)
{
    c.d += stp_pixel_centre(at, level) - stp_pixel_centre(here, 0);
    vec3 s = stp_ellipse_place(c, ray, -c.d);
    bool own = level == 0 && at == here;
    float q = c.radius > 0.0 ? dot(s, s) : own ? 0.0 : STP_ELLIPSE_OUTSIDE;
    q = own ? min(q, 1.0) : q;
    float farther = stp_ellipse_farther(c, s), extent = c.z_max - c.z_min;
    c.z_min += farther;
    c.z_max = c.z_min + extent;
    c.middle += farther;
    return stp_template_hit(c, q);
}

// A bit set has one bit for each pixel of a window around `here`, row by row.
#define STP_TEMPLATE_WORDS ((STP_TEMPLATE * STP_TEMPLATE + 31) / 32)
#define STP_TEMPLATE_LEVELS 16

ivec2 stp_template_at(ivec2 here, int level, int bit)
{
    return (here >> level) + ivec2(bit % STP_TEMPLATE, bit / STP_TEMPLATE) - STP_TEMPLATE / 2;
}

bool stp_template_closes(stp_template_gap gap)
{
    return bitCount(gap.sides.x) >= 3 || bitCount(gap.sides.y) == 4;
}

// The pixel that closes a gap.
stp_pixel stp_template_close(stp_template_gap gap, ivec2 here, vec3 ray)
{
    stp_pixel pulled = stp_template_pulled(gap.nearest.xy, gap.nearest.z);
    stp_pixel p = stp_template_look(pulled, here, gap.nearest.xy, gap.nearest.z, ray).pixel;
    p.tag = stp_tag_from(p.tag, max(1, stp_tag_source(p.tag)));
    return p;
}

// Makes a pixel of level 0 from all levels up to pyramid_level. First finds the ellipses that cover
// the pixel, and how deep the front surface is; then averages the ellipses of the front surface.
stp_pixel stp_template(ivec2 here)
{
    const int own_bit = STP_TEMPLATE * STP_TEMPLATE / 2;
    vec3 ray = stp_ray(stp_pixel_centre(here, 0));
    stp_pixel front = stp_pixel_invalid();
    float end = STP_ELLIPSE_OUTSIDE; // least end of all intervals: those that begin before it all meet
    stp_template_gap gap = stp_template_gap(uvec2(0u), STP_ELLIPSE_OUTSIDE, ivec3(0));
    uint covers[STP_TEMPLATE_LEVELS * STP_TEMPLATE_WORDS];
    for (int level = 0; level <= pyramid_level; level++) {
        ivec2 size = (ivec2(viewport.xy) + (1 << level) - 1) >> level;
        for (int bit = 0; bit < STP_TEMPLATE * STP_TEMPLATE; bit++) {
            ivec2 at = stp_template_at(here, level, bit);
            stp_pixel pulled = stp_template_pulled(at, level);
            stp_template_hit hit = stp_template_look(pulled, here, at, level, ray);
            bool inside = all(lessThan(uvec2(at), uvec2(size)));
            hit.pixel.tag = inside && stp_template_lives(pulled, at, level) ? hit.pixel.tag : 0;
            stp_template_miss(gap, hit, at, level);
            stp_pixel c = hit.pixel;
            c.tag = hit.q <= 1.0 ? c.tag : 0;
            front = stp_nearer(front, c);
            end = c.tag != 0 ? min(end, c.z_max) : end;
            int word = level * STP_TEMPLATE_WORDS + (bit >> 5);
            uint covering = c.tag != 0 ? 1u << (bit & 31) : 0u;
            covers[word] = (bit & 31) == 0 ? covering : covers[word] | covering;
        }
    }
    front.z_max = end;
    stp_blend blend = stp_blend_begin();
    int source = 15; // the least
    for (int word = 0; word < (pyramid_level + 1) * STP_TEMPLATE_WORDS; word++) {
        int level = word / STP_TEMPLATE_WORDS, first = word % STP_TEMPLATE_WORDS * 32;
        for (uint left = covers[word]; left != 0u; left &= left - 1u) {
            int bit = first + findLSB(left);
            ivec2 at = stp_template_at(here, level, bit);
            stp_template_hit hit = stp_template_look(stp_template_pulled(at, level), here, at, level, ray);
            stp_blend_add(blend, front, hit.pixel, exp(-2.0 * hit.q));
            int from = level == 0 && bit == own_bit ? 0 : max(1, stp_tag_source(hit.pixel.tag));
            source = hit.pixel.tag != 0 && hit.pixel.z_min <= end ? min(source, from) : source;
        }
    }
    stp_pixel p = stp_blend_end(blend, front).sum;
    p.radius = sqrt(p.radius);
    p.tag = stp_tag_from(front.tag, source);
    if (front.tag == 0 && stp_template_closes(gap))
        return stp_template_close(gap, here, ray);
    if (front.tag == 0)
        p = stp_pixel_invalid();
    return p;
}

#endif
