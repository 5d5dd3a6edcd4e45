// Contours: lines of equal height ("Contours" in README.md). Needs project.glsl and pixel.glsl.

// Width of a line in pixels; each fifth is wider. Lines that are closer together than the first
// spacing are not drawn; from the second on they are whole.
#define STP_CONTOUR_WIDTH 1.2
#define STP_CONTOUR_WIDTH_FIFTH 2.2
#define STP_CONTOUR_SPACING vec2(3.0, 6.0)
// A surface that rises less than this share of a step per pixel is level: it has no lines.
#define STP_CONTOUR_LEVEL 1e-4
// A surface that is turned away more (cosine) counts as facing the eye.
#define STP_CONTOUR_GRAZING 0.05

// Where the ray through window coordinates meets the plane through a position of eye space.
vec3 stp_contour_meet(vec2 window, vec3 position, vec3 n)
{
    vec2 off = (window - centre.xy) / viewport.z;
#if STP_ORTHOGRAPHIC
    return vec3(off, position.z + dot(n.xy, position.xy - off) / n.z);
#else
    vec3 ray = vec3(off, -1.0);
    return ray * (dot(n, position) / dot(n, ray));
#endif
}

// The depth in the middle of a pixel's surface. A pixel's interval ends by the thickness of a sample
// behind the surface ("Pixel" in README.md); pull takes the least of z_min and the greatest of z_max,
// which lie as far on both sides of the middle.
float stp_contour_depth(stp_pixel p, float cosine)
{
    float k = min(1.0, abs(cosine));
    float slope = min(5.0, sqrt(1.0 - k * k) / max(k, 1e-3));
    float thickness = max(p.radius, 1.25 * slope / stp_pixels_per_unit(p.z_min));
    return 0.5 * (p.z_min + max(p.z_max - thickness, p.z_min));
}

// The share of a pixel that a line covers. window: the pixel's centre.
float stp_contour(stp_pixel p, vec3 n, vec2 window)
{
    float step = terms.z;
    vec3 up = vec3(axis_right.z, axis_up.z, axis_back.z); // the scan's z in eye space
    vec3 ray = stp_ray(window);
    float cosine = dot(n, ray), depth = stp_contour_depth(p, cosine);
    n = abs(cosine) > STP_CONTOUR_GRAZING ? n : -ray;
    vec2 off = (window + p.d - centre.xy) / viewport.z;
    vec3 position = STP_ORTHOGRAPHIC != 0 ? vec3(off, -depth) : vec3(off, -1.0) * depth;
    float height = dot(up, stp_contour_meet(window, position, n));
    vec2 rise = vec2(dot(up, stp_contour_meet(window + vec2(1.0, 0.0), position, n)),
                     dot(up, stp_contour_meet(window + vec2(0.0, 1.0), position, n))) - height;
    float slope = max(length(rise) / step, 1e-20); // steps a pixel
    float number = (height + terms.w) / step, line = round(number);
    float width = mod(line + 0.5, 5.0) < 1.0 ? STP_CONTOUR_WIDTH_FIFTH : STP_CONTOUR_WIDTH;
    float away = abs(number - line) / slope; // pixels
    float apart = smoothstep(STP_CONTOUR_SPACING.x, STP_CONTOUR_SPACING.y, 1.0 / slope);
    return slope > STP_CONTOUR_LEVEL ? apart * clamp(0.5 * width + 0.5 - away, 0.0, 1.0) : 0.0;
}
