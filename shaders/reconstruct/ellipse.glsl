// The quadratic form of a projected disc (MKC08, section 3; ours is exact off the axis, too: "The
// ellipse" in README.md). Needs pixel.glsl and project.glsl.

// Least semi-axes, pixels. A sample stands for at least its pixel's neighbourhood, and grazing
// ellipses must not vanish. If a pixel sees all ellipses around it, reaching the pixel itself is
// enough.
#if STP_SPLAT || STP_TEMPLATE
#define STP_ELLIPSE_FLOOR 0.75
#else
#define STP_ELLIPSE_FLOOR 1.25
#endif
#define STP_ELLIPSE_FLOOR_LINE 0.5 // pixels of a line touch each other
#define STP_ELLIPSE_OUTSIDE 1e30
#define STP_ELLIPSE_FAR 1e15 // a place far outside

float stp_ellipse_floor(int tag)
{
    return stp_tag_line(tag) ? STP_ELLIPSE_FLOOR_LINE : STP_ELLIPSE_FLOOR;
}

// Where the ray through a point meets the disc's plane: from the disc's centre, in units of its
// projected radius. Exact in perspective except for the floors. least: floor of the minor
// semi-axis, pixels. ray: unit, through the point. offset: from the ellipse's centre to the point,
// pixels. If the place is behind the eye, returns a place far outside (orthographic: only where
// depths are used, since otherwise the place does not change).
vec3 stp_ellipse_place_least(stp_pixel p, vec3 ray, vec2 offset, float least)
{
    float units = STP_ORTHOGRAPHIC != 0 ? 1.0 : p.z_min; // times 1 / f: world units a pixel
    float inverse = min(units / (p.radius * viewport.z), 1.0 / stp_ellipse_floor(p.tag));
    vec2 delta = offset * inverse;
    vec3 normal = stp_tag_tube(p.tag) ? -ray : p.normal;
    float k = dot(normal, ray);
    float magnitude = max(abs(k), min(1.0, least * inverse));
    float along = dot(delta, normal.xy) / (k > 0.0 ? magnitude : -magnitude);
    vec3 s = vec3(delta, 0.0) - ray * along;
    // Where the eye is, in the same units.
    float eye = viewport.z * inverse * (STP_ORTHOGRAPHIC != 0 ? p.z_min : 1.0);
    return (STP_ORTHOGRAPHIC != 0 && STP_TEMPLATE == 0) || s.z < eye ? s : vec3(STP_ELLIPSE_FAR, STP_ELLIPSE_FAR, 0.0);
}

vec3 stp_ellipse_place(stp_pixel p, vec3 ray, vec2 offset)
{
    return stp_ellipse_place_least(p, ray, offset, stp_ellipse_floor(p.tag));
}

// Projected radius, pixels.
float stp_ellipse_radius_px(stp_pixel p)
{
    return max(p.radius * stp_pixels_per_unit(p.z_min), stp_ellipse_floor(p.tag));
}

// The greatest q at which an ellipse closes a gap. Where a grid has no samples, nothing may be
// drawn: its gaps are no wider than the least ellipse.
float stp_ellipse_gap(stp_pixel p, float q)
{
#if STP_GRID
    float reach = 1.0 + stp_ellipse_floor(p.tag) / stp_ellipse_radius_px(p);
    q = min(q, reach * reach);
#endif
    return q;
}

// How much deeper than its centre the disc is at a result of stp_ellipse_place.
float stp_ellipse_farther(stp_pixel p, vec3 place)
{
    return p.radius > 0.0 ? -place.z * stp_ellipse_radius_px(p) / stp_pixels_per_unit(p.z_min) : 0.0;
}

// q: below 1 inside the ellipse, 1 at the rim.
float stp_ellipse_least(stp_pixel p, vec3 ray, vec2 offset, float least)
{
    vec3 s = stp_ellipse_place_least(p, ray, offset, least);
    float q = dot(s, s);
    return p.radius > 0.0 ? q : offset == vec2(0.0) ? 0.0 : STP_ELLIPSE_OUTSIDE;
}

float stp_ellipse(stp_pixel p, vec3 ray, vec2 offset)
{
    return stp_ellipse_least(p, ray, offset, stp_ellipse_floor(p.tag));
}
