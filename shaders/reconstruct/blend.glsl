// Shared by pull, push and templates: finds the front of some candidates, and the mean of those
// that belong to its surface. box averages radii (MKC07), the others squares of radii. The code has
// no branches and no indexed arrays: software rasterisers run both sides of every branch, and pay
// for arrays in memory. Needs pixel.glsl.

struct stp_blend {
    stp_pixel sum;
    float total;    // of the weights
    float distance; // sum of the centres' squared distances from the pixel's centre; not with box
    float farthest; // greatest z_max
};

// The nearer of two pixels, the first if equal. Copies only the members that blending needs.
stp_pixel stp_nearer(stp_pixel front, stp_pixel c)
{
    bool nearer = c.tag != 0 && (front.tag == 0 || c.z_min < front.z_min);
    front.normal = nearer ? c.normal : front.normal;
    front.z_min = nearer ? c.z_min : front.z_min;
    front.z_max = nearer ? c.z_max : front.z_max;
    front.tag = nearer ? c.tag : front.tag;
    return front;
}

stp_pixel stp_front(stp_pixel c0, stp_pixel c1, stp_pixel c2, stp_pixel c3)
{
    return stp_nearer(stp_nearer(stp_nearer(c0, c1), c2), c3);
}

// Adds a candidate if its depth interval meets the front's. If either is two-sided, turns the
// candidate's normal to the front's side.
void stp_blend_add(inout stp_blend blend, stp_pixel front, stp_pixel c, float weight)
{
    float w = c.tag != 0 && c.z_min <= front.z_max ? weight : 0.0;
    bool two_sided = ((front.tag - 1 | c.tag - 1) & 8) != 0;
    float side = two_sided && dot(c.normal, front.normal) < 0.0 ? -w : w;
    bool alike = stp_tag_tube(front.tag) == stp_tag_tube(c.tag); // a tangent is no normal
    blend.sum.normal += alike ? side * c.normal : vec3(0.0);
    blend.sum.radius += w * (STP_BOX != 0 ? c.radius : c.radius * c.radius);
    // Relative to the front's depths, so that equal depths stay equal with any weights: they decide
    // ties.
    blend.sum.z_min += w * (c.z_min - front.z_min);
    blend.sum.z_max += w * (c.z_max - front.z_max);
    blend.sum.middle += w * (c.middle - front.z_min);
    blend.sum.d += w * c.d;
    blend.sum.colour += w * c.colour;
    blend.total += w;
    blend.distance += STP_BOX != 0 ? 0.0 : w * dot(c.d, c.d);
    blend.farthest = w > 0.0 ? max(blend.farthest, c.z_max) : blend.farthest;
}

stp_blend stp_blend_begin()
{
    return stp_blend(stp_pixel_invalid(), 0.0, 0.0, 0.0);
}

// Turns sums into means.
stp_blend stp_blend_end(stp_blend blend, stp_pixel front)
{
    float scale = 1.0 / max(blend.total, 1e-30);
    float norm = dot(blend.sum.normal, blend.sum.normal);
    blend.sum.normal = norm > 0.0 ? blend.sum.normal * inversesqrt(norm) : front.normal;
    blend.sum.radius *= scale;
    blend.sum.z_min = front.z_min + blend.sum.z_min * scale;
    blend.sum.z_max = front.z_max + blend.sum.z_max * scale;
    blend.sum.middle = front.z_min + blend.sum.middle * scale;
    blend.sum.d *= scale;
    blend.sum.colour *= scale;
    blend.distance *= scale;
    return blend;
}

// The greatest radius about a place that stays in a candidate's disc.
float stp_blend_within(stp_pixel front, stp_pixel c, vec2 place, float unit)
{
    return c.tag != 0 && c.z_min <= front.z_max ? c.radius - distance(c.d, place) * unit : 0.0;
}

// The radius of the mean of pixels. Where holes may only grow, that disc lies in one of theirs.
float stp_blend_radius(stp_blend blend, stp_pixel front, stp_pixel c0, stp_pixel c1, stp_pixel c2, stp_pixel c3)
{
    float radius = STP_BOX != 0 ? blend.sum.radius : sqrt(blend.sum.radius);
#if STP_GRID == 2
    vec2 place = blend.sum.d;
    float unit = 1.0 / max(stp_pixels_per_unit(front.z_min), 1e-30);
    float within = max(max(stp_blend_within(front, c0, place, unit), stp_blend_within(front, c1, place, unit)),
                       max(stp_blend_within(front, c2, place, unit), stp_blend_within(front, c3, place, unit)));
    radius = min(radius, max(within, 1e-3 * unit));
#endif
    return radius;
}

stp_blend stp_blend_four(stp_pixel front, stp_pixel c0, stp_pixel c1, stp_pixel c2, stp_pixel c3,
                         vec4 weights)
{
    stp_blend blend = stp_blend_begin();
    stp_blend_add(blend, front, c0, weights.x);
    stp_blend_add(blend, front, c1, weights.y);
    stp_blend_add(blend, front, c2, weights.z);
    stp_blend_add(blend, front, c3, weights.w);
    return stp_blend_end(blend, front);
}
