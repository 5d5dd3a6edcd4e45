// What of the picture a splat may cover. Needs layout.glsl, project.glsl, ellipse.glsl.

struct stp_splat {
    vec4 place;   // window position of the centre, 1 / radius in pixels, depth
    vec3 normal;
    float extent; // how deep its interval is
};

struct stp_splat_bound {
    vec2 centre;    // window coordinates
    vec2 size;      // half the box around it; infinite where the disc may reach the eye
    vec2 direction; // about that of the ellipse's short axis
    float width;    // half its width along that
};

// How far the image of a disc reaches along a direction of the window, from that of its centre: the most that
// radius_px (u.xy + ray u.z) . direction comes to, u on the unit disc's rim, where the depth is `nearest` times the
// centre's or more.
float stp_splat_reach(vec2 direction, vec2 ray, vec3 normal, float radius_px, float nearest)
{
    vec3 g = vec3(direction, dot(direction, ray));
    float along = dot(g, normal), k = abs(dot(vec3(ray, -1.0), normal));
    float part = max(dot(g, g) - along * along, 0.0);
    float least = k * radius_px < 1.25 * STP_ELLIPSE_FLOOR ? STP_ELLIPSE_FLOOR * STP_ELLIPSE_FLOOR : 0.0;
    return sqrt(part * radius_px * radius_px + least) / nearest;
}

stp_splat_bound stp_splat_bound_of(stp_splat s)
{
    const bool orthographic = STP_ORTHOGRAPHIC != 0;
    vec2 ray = orthographic ? vec2(0.0) : (s.place.xy - centre.xy) / viewport.z;
    float radius_px = 1.0 / s.place.z;
    float rises = radius_px / viewport.z * sqrt(max(1.0 - s.normal.z * s.normal.z, 0.0)); // over the depth
    float nearest = orthographic ? 1.0 : 1.0 - rises;
    float slope = length(s.normal.xy);
    vec2 direction = slope > 1e-6 ? s.normal.xy / slope : vec2(1.0, 0.0);
    stp_splat_bound b = stp_splat_bound(s.place.xy, vec2(STP_ELLIPSE_OUTSIDE), direction, STP_ELLIPSE_OUTSIDE);
    if (nearest * s.place.w > viewport.w) {
        b.size.x = stp_splat_reach(vec2(1.0, 0.0), ray, s.normal, radius_px, nearest);
        b.size.y = stp_splat_reach(vec2(0.0, 1.0), ray, s.normal, radius_px, nearest);
        b.width = stp_splat_reach(direction, ray, s.normal, radius_px, nearest);
    }
    return b;
}

// The pixels whose centres lie in the box: the first and the last column and row.
ivec4 stp_splat_pixels(stp_splat_bound b)
{
    const float slack = 0.01;
    vec2 low = max(ceil(b.centre - b.size - 0.5 - slack), vec2(0.0));
    vec2 high = min(floor(b.centre + b.size - 0.5 + slack), viewport.xy - 1.0);
    return ivec4(low, high);
}

// Whether the ellipse may cover one of the pixels of a bin.
bool stp_splat_touches(stp_splat_bound b, ivec2 at, ivec2 bits)
{
    vec2 half_size = 0.5 * vec2((ivec2(1) << bits) - 1);
    vec2 away = vec2(at << bits) + 0.5 + half_size - b.centre;
    return abs(dot(away, b.direction)) <= b.width + dot(half_size, abs(b.direction)) + 0.01;
}
