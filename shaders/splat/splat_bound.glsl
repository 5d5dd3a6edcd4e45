// Which part of the picture a splat may cover. Needs layout.glsl, project.glsl, ellipse.glsl.

struct stp_splat {
    vec4 place;   // window position of the centre, 1 / radius in pixels, depth
    vec3 normal;
    float extent; // depth of its interval
};

// How far the image of a disc reaches from its centre's image along a direction of the window: the
// greatest value of radius_px (u.xy + ray u.z) . direction over the unit disc's rim u, if depths on
// the disc are at least `nearest` times the centre's depth.
float stp_splat_reach(vec2 direction, vec2 ray, vec3 normal, float radius_px, float nearest)
{
    vec3 g = vec3(direction, dot(direction, ray));
    float along = dot(g, normal), k = abs(dot(vec3(ray, -1.0), normal));
    float part = max(dot(g, g) - along * along, 0.0);
    float least = k * radius_px < 1.25 * STP_ELLIPSE_FLOOR ? STP_ELLIPSE_FLOOR * STP_ELLIPSE_FLOOR : 0.0;
    return sqrt(part * radius_px * radius_px + least) / nearest;
}

// Half the size of the bounding box, from the centre; infinite if the disc may reach the eye.
vec2 stp_splat_size(stp_splat s)
{
    const bool orthographic = STP_ORTHOGRAPHIC != 0;
    vec2 ray = orthographic ? vec2(0.0) : (s.place.xy - centre.xy) / viewport.z;
    float radius_px = 1.0 / s.place.z;
    // How far the disc comes nearer than its centre, divided by the depth.
    float rises = radius_px / viewport.z * sqrt(max(1.0 - s.normal.z * s.normal.z, 0.0));
    float nearest = orthographic ? 1.0 : 1.0 - rises;
    if (nearest * s.place.w <= viewport.w)
        return vec2(STP_ELLIPSE_OUTSIDE);
    return vec2(stp_splat_reach(vec2(1.0, 0.0), ray, s.normal, radius_px, nearest),
                stp_splat_reach(vec2(0.0, 1.0), ray, s.normal, radius_px, nearest));
}

// The pixels whose centres lie in the box: the first and the last column and row.
ivec4 stp_splat_pixels(stp_splat s, vec2 size)
{
    const float slack = 0.01;
    vec2 low = max(ceil(s.place.xy - size - 0.5 - slack), vec2(0.0));
    vec2 high = min(floor(s.place.xy + size - 0.5 + slack), viewport.xy - 1.0);
    return ivec4(low, high);
}
