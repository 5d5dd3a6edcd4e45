// The quadratic form of a projected disc (CG08, section 3; ours looks along the ray through the
// disc's centre, see README.md). Needs pixel.glsl and project.glsl.

// Least minor semi-axis, pixels: keeps grazing ellipses from vanishing.
#define STP_ELLIPSE_FLOOR 0.5
#define STP_ELLIPSE_OUTSIDE 1e30

// 1 at the rim. centre: of the ellipse, window pixels; offset from it, pixels.
float stp_ellipse(stp_pixel p, vec2 centre, vec2 offset)
{
    float radius = p.radius * stp_pixels_per_unit(p.z_min);
    if (radius <= 0.0)
        return offset == vec2(0.0) ? 0.0 : STP_ELLIPSE_OUTSIDE;
    vec3 w = stp_ray(centre);
    vec3 delta = vec3(offset / radius, 0.0);
    float k = dot(p.normal, w);
    float magnitude = max(abs(k), min(1.0, STP_ELLIPSE_FLOOR / radius));
    vec3 s = delta - w * (dot(delta, p.normal) / (k > 0.0 ? magnitude : -magnitude));
    return dot(s, s);
}
