// The quadratic form of a projected disc (CG08, section 3; ours looks along the ray through the
// disc's centre, see README.md). Needs pixel.glsl and project.glsl.

// Least semi-axes, pixels: a sample stands for its pixel's neighbourhood at least, and grazing
// ellipses do not vanish.
#define STP_ELLIPSE_FLOOR 1.25
#define STP_ELLIPSE_OUTSIDE 1e30

// 1 at the rim. centre: of the ellipse, window pixels; offset from it, pixels.
float stp_ellipse(stp_pixel p, vec2 centre, vec2 offset)
{
    float inverse = 1.0 / max(p.radius * stp_pixels_per_unit(p.z_min), STP_ELLIPSE_FLOOR);
    vec3 w = stp_ray(centre);
    vec2 delta = offset * inverse;
    float k = dot(p.normal, w);
    float magnitude = max(abs(k), min(1.0, STP_ELLIPSE_FLOOR * inverse));
    float along = dot(delta, p.normal.xy) / (k > 0.0 ? magnitude : -magnitude);
    vec3 s = vec3(delta, 0.0) - w * along;
    float q = dot(s, s);
    return p.radius > 0.0 ? q : offset == vec2(0.0) ? 0.0 : STP_ELLIPSE_OUTSIDE;
}
