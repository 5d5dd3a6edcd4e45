// Push: interpolates pixels that are invalid or hidden behind nearer ellipses from four pixels of
// the next coarser level. Weights: biquadratic B-spline (MKC07) times the ellipse's Gaussian
// (MKC08). Needs layout.glsl, project.glsl, pixel.glsl, ellipse.glsl, blend.glsl.

// If the ellipses of three or four coarse pixels lie around a pixel and none reaches it, the
// nearest one counts up to this q: averaging opens gaps that no surface has.
#define STP_PUSH_GAP_3 2.0
#define STP_PUSH_GAP_4 4.0
// Pixels: if centres are no farther apart, the ellipses are of one disc, and beside a disc there is
// no gap; unless the picture lacks blocks.
#define STP_PUSH_SAME 0.1
// Pixels: least minor semi-axis at an outline, where the usual floor would move the outline
// outwards.
#define STP_PUSH_OUTLINE_FLOOR 0.6

layout(location = 12) uniform bool incomplete; // the picture lacks blocks

// exp(-q / 2) for q in 0..2, to 2.2e-5: least-squares fit in Chebyshev polynomials of degree 4.
// Beyond q = 1 only the candidate of least q counts, and its weight does not matter.
vec4 stp_push_kernel(vec4 q)
{
    q = min(q, 2.0);
    return 0.9999789 + q * (-0.4996764 + q * (0.12383386 + q * (-0.01920298 + q * 0.00159756)));
}

// A coarse pixel. Its d becomes the position of its ellipse's centre, viewport pixels.
stp_pixel stp_push_look(ivec2 p)
{
    stp_pixel c = stp_pixel_coarse(p);
    c.d += stp_pixel_centre(p, pyramid_level + 1);
    c.tag = stp_inside(p) ? c.tag : 0;
    return c;
}

// Whether `centre` lies on the side of the disc's centre to which the disc's normal points in the
// image: if the disc is part of an outline, that is outside. True if there is no disc, false for a
// line.
bool stp_push_beyond(stp_pixel c, vec2 centre)
{
    return c.tag == 0 || (!stp_tag_line(c.tag) && dot(centre - c.d, c.normal.xy) > 0.0);
}

// A coarse pixel as seen from `centre`; q says how far `centre` is from the centre of the ellipse.
stp_pixel stp_push_candidate(stp_pixel c, vec2 centre, vec3 ray, bool outline, out float q)
{
    float least = outline ? STP_PUSH_OUTLINE_FLOOR : stp_ellipse_floor(c.tag);
    c.d -= centre;
    q = c.tag != 0 ? stp_ellipse_least(c, ray, -c.d, least) : STP_ELLIPSE_OUTSIDE;
    return c;
}

// Whether the candidates, three or four of them valid, come from several discs: whether their
// centres differ.
bool stp_push_differ(stp_pixel c0, stp_pixel c1, stp_pixel c2, stp_pixel c3)
{
    vec2 first = c0.tag != 0 ? c0.d : c1.d, d1 = c1.d - first, d2 = c2.d - first, d3 = c3.d - first;
    vec3 apart = vec3(dot(d1, d1), dot(d2, d2), dot(d3, d3)) * vec3(notEqual(ivec3(c1.tag, c2.tag, c3.tag), ivec3(0)));
    return max(max(apart.x, apart.y), apart.z) > STP_PUSH_SAME * STP_PUSH_SAME;
}

// Finishes a pixel of the pulled (fine) level from four of level l + 1: its parent, the parent's
// neighbours on the pixel's side along x and along y, and the one diagonally between. pushed: the
// pixel has changed.
stp_pixel stp_push_from(ivec2 here, stp_pixel parent, stp_pixel beside_x, stp_pixel beside_y, stp_pixel between,
                        out bool pushed)
{
    vec2 centre = stp_pixel_centre(here, pyramid_level);
    vec3 ray = stp_ray(centre);
    stp_pixel own = stp_pixel_fine(here);
    bool open = own.tag == 0 && (parent.tag == 0 || beside_x.tag == 0 || beside_y.tag == 0 || between.tag == 0);
    bool outline = open && stp_push_beyond(parent, centre) && stp_push_beyond(beside_x, centre) &&
                   stp_push_beyond(beside_y, centre) && stp_push_beyond(between, centre);
    vec4 q;
    stp_pixel c0 = stp_push_candidate(parent, centre, ray, outline, q.x);
    stp_pixel c1 = stp_push_candidate(beside_x, centre, ray, outline, q.y);
    stp_pixel c2 = stp_push_candidate(beside_y, centre, ray, outline, q.z);
    stp_pixel c3 = stp_push_candidate(between, centre, ray, outline, q.w);
    bool parent_valid = c0.tag != 0;

    float least = min(min(q.x, q.y), min(q.z, q.w));
    float valid = dot(vec4(lessThan(q, vec4(STP_ELLIPSE_OUTSIDE))), vec4(1.0));
    if (stp_tag_line(c0.tag) || stp_tag_line(c1.tag) || stp_tag_line(c2.tag) || stp_tag_line(c3.tag))
        valid = 0.0; // between lines there are gaps
    if (!incomplete && !stp_push_differ(c0, c1, c2, c3))
        valid = 0.0;
    float gap = valid >= 4.0 ? STP_PUSH_GAP_4 : valid >= 3.0 ? STP_PUSH_GAP_3 : 1.0;
    float reach = clamp(least, 1.0, gap);
    c0.tag = q.x <= stp_ellipse_gap(c0, reach) ? c0.tag : 0;
    c1.tag = q.y <= stp_ellipse_gap(c1, reach) ? c1.tag : 0;
    c2.tag = q.z <= stp_ellipse_gap(c2, reach) ? c2.tag : 0;
    c3.tag = q.w <= stp_ellipse_gap(c3, reach) ? c3.tag : 0;
    vec4 weights = vec4(9.0, 3.0, 3.0, 1.0) / 16.0;
#if !STP_BOX
    weights *= stp_push_kernel(q);
#endif
    stp_pixel front = stp_front(c0, c1, c2, c3);
    stp_blend blend = stp_blend_four(front, c0, c1, c2, c3, weights);
    stp_pixel p = blend.sum;
#if !STP_BOX
    p.radius = sqrt(p.radius);
#endif
    p.tag = front.tag;

    // A valid pixel stays, unless it lies behind its parent's interval and an ellipse lies in front
    // of it.
    bool occluded = parent_valid && own.z_min > c0.z_max && front.z_max < own.z_min;
    pushed = front.tag != 0 && (own.tag == 0 || occluded);
    if (!pushed)
        p = own;
    return p;
}

stp_pixel stp_push(ivec2 here)
{
    ivec2 parent = here >> 1;
    ivec2 side = 2 * (here & 1) - 1;
    bool pushed;
    return stp_push_from(here, stp_push_look(parent), stp_push_look(parent + ivec2(side.x, 0)),
                         stp_push_look(parent + ivec2(0, side.y)), stp_push_look(parent + side), pushed);
}
