// Fine to coarse: a pixel of level l out of the four of level l - 1 under it (PBG07; the ellipse
// test is CG08's, and TUT08's which go on to level l at all). Reads level l - 1 as fine, writes level l.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "pixel.glsl"
#include "pixel_out.glsl"
#include "ellipse.glsl"
#include "blend.glsl"
#include "template.glsl"

// A finer pixel as seen from `centre`; invalid where its ellipse does not reach it, or stays behind.
stp_pixel stp_pull_candidate(ivec2 p, vec2 centre, vec3 ray)
{
    stp_pixel c = stp_pixel_fine(p);
    vec2 middle = stp_pixel_centre(p, pyramid_level - 1) + c.d;
    c.d = middle - centre;
#if STP_TEMPLATE
    bool reaches = stp_template_carries(c, pyramid_level - 1);
#else
    bool reaches = STP_BOX != 0 ? c.radius > 0.0 : stp_ellipse(c, ray, -c.d) <= 1.0;
#endif
    c.tag = reaches && stp_inside(p) ? c.tag : 0;
    return c;
}

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec2 centre = stp_pixel_centre(here, pyramid_level);
    vec3 ray = stp_ray(centre);
    stp_pixel c0 = stp_pull_candidate(2 * here, centre, ray);
    stp_pixel c1 = stp_pull_candidate(2 * here + ivec2(1, 0), centre, ray);
    stp_pixel c2 = stp_pull_candidate(2 * here + ivec2(0, 1), centre, ray);
    stp_pixel c3 = stp_pull_candidate(2 * here + ivec2(1, 1), centre, ray);
    stp_pixel front = stp_front(c0, c1, c2, c3);
    stp_blend blend = stp_blend_four(front, c0, c1, c2, c3, vec4(1.0));

    // The disc with the second moment of those it stands for: R^2 = mean r^2 + 2 variance. A line grows no wider.
    stp_pixel p = blend.sum;
    float unit = 1.0 / max(stp_pixels_per_unit(front.z_min), 1e-30);
    float variance = stp_tag_line(front.tag) ? 0.0 : max(0.0, blend.distance - dot(p.d, p.d)) * unit * unit;
    p.radius = sqrt(p.radius + 2.0 * variance);
    p.z_min = front.z_min;
    p.z_max = blend.farthest;
    p.tag = stp_tag_from(front.tag, pyramid_level);
    if (front.tag == 0)
        p = stp_pixel_invalid();
    stp_pixel_write(p);
}
