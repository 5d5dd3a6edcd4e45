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
// Up to this q a nearer ellipse hides a pixel that its parent does not hide. Discs reach beyond
// outlines, so less than 1 is nearer to the truth.
#define STP_PUSH_HIDES 0.75
// How far push looks for what pull left out behind a nearer surface, and how wide a disc beside the
// pixel must be for that: coarse pixels.
#define STP_PUSH_FURTHER 4
#define STP_PUSH_WIDE 2.0

layout(location = 12) uniform bool incomplete; // the picture lacks blocks

// exp(-q / 2) for q in 0..2, to 2.2e-5: least-squares fit in Chebyshev polynomials of degree 4.
// Beyond q = 1 only the candidate of least q counts, and its weight does not matter.
vec4 stp_push_kernel(vec4 q)
{
    q = min(q, 2.0);
    return 0.9999789 + q * (-0.4996764 + q * (0.12383386 + q * (-0.01920298 + q * 0.00159756)));
}

// A coarse pixel; beyond the border the one mirrored there, since pixels at the border would else
// have too few beside them. Its d becomes the position of its ellipse's centre, viewport pixels.
stp_pixel stp_push_look(ivec2 p)
{
    p = abs(min(p, 2 * read_size - 2 - p));
    stp_pixel c = stp_pixel_coarse(p);
    c.d += stp_pixel_centre(p, pyramid_level + 1);
    c.tag = stp_inside(p) ? c.tag : 0;
    return c;
}

// Whether `centre` lies on the side of the disc's centre that the disc's normal points to in the
// image. If the disc is part of an outline, that side is outside. True if there is no disc, false
// for a line.
bool stp_push_beyond(stp_pixel c, vec2 centre)
{
    return c.tag == 0 || (!stp_tag_line(c.tag) && dot(centre - c.d, c.normal.xy) > 0.0);
}

// A coarse pixel as seen from `centre`; q says how far `centre` is from the centre of the ellipse.
// outline: with the least semi-axis of an outline.
stp_pixel stp_push_candidate(stp_pixel c, vec2 centre, vec3 ray, bool outline, out float q)
{
    float least = outline ? STP_PUSH_OUTLINE_FLOOR : stp_ellipse_floor(c.tag);
    c.d -= centre;
    q = c.tag != 0 ? stp_ellipse_least(c, ray, -c.d, least) : STP_ELLIPSE_OUTSIDE;
    return c;
}

// The radius of a coarse pixel's disc, in such pixels.
float stp_push_width(stp_pixel c)
{
    float width = c.radius * stp_pixels_per_unit(c.z_min) / float(2 << pyramid_level);
    return c.tag != 0 ? width : 0.0;
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
// pixel has changed. missed: none of the four reaches it, but discs are so wide that it may belong to
// one that pull left out behind another: stp_push_further may know better. Not at level 0, where the
// loop would cost a software driver a fifth to a third of a frame, and finds little.
stp_pixel stp_push_from(ivec2 here, stp_pixel parent, stp_pixel beside_x, stp_pixel beside_y, stp_pixel between,
                        out bool pushed, out bool missed)
{
    vec2 centre = stp_pixel_centre(here, pyramid_level);
    vec3 ray = stp_ray(centre);
    stp_pixel own = stp_pixel_fine(here);
    bool open = own.tag == 0 && (parent.tag == 0 || beside_x.tag == 0 || beside_y.tag == 0 || between.tag == 0);
    bool outline = open && stp_push_beyond(parent, centre) && stp_push_beyond(beside_x, centre) &&
                   stp_push_beyond(beside_y, centre) && stp_push_beyond(between, centre);
    bool hidden = parent.tag != 0 && own.z_min > parent.z_max; // behind its parent's interval
    bool seen = own.tag != 0 && !hidden;
    outline = outline || seen;
    vec4 q;
    stp_pixel c0 = stp_push_candidate(parent, centre, ray, outline, q.x);
    stp_pixel c1 = stp_push_candidate(beside_x, centre, ray, outline, q.y);
    stp_pixel c2 = stp_push_candidate(beside_y, centre, ray, outline, q.z);
    stp_pixel c3 = stp_push_candidate(between, centre, ray, outline, q.w);
    float widest = max(max(stp_push_width(c0), stp_push_width(c1)), max(stp_push_width(c2), stp_push_width(c3)));

    ivec2 beside = (here >> 1) + 2 * (here & 1) - 1;
    bvec2 outside = notEqual(beside, clamp(beside, ivec2(0), read_size - 1));
    vec3 inner = max(q.yzw, vec3(bvec3(outside, any(outside))) * STP_ELLIPSE_OUTSIDE);
    if (min(min(q.x, inner.x), min(inner.y, inner.z)) <= 1.0)
        q.yzw = inner; // mirrored pixels count only if no other reaches
    float least = min(min(q.x, q.y), min(q.z, q.w));
    float valid = dot(vec4(lessThan(q, vec4(STP_ELLIPSE_OUTSIDE))), vec4(1.0));
    if (stp_tag_line(c0.tag) || stp_tag_line(c1.tag) || stp_tag_line(c2.tag) || stp_tag_line(c3.tag))
        valid = 0.0; // between lines there are gaps
    if (!incomplete && !stp_push_differ(c0, c1, c2, c3))
        valid = 0.0;
    float gap = valid >= 4.0 ? STP_PUSH_GAP_4 : valid >= 3.0 ? STP_PUSH_GAP_3 : 1.0;
    float reach = seen ? STP_PUSH_HIDES : clamp(least, 1.0, gap);
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
    p.radius = stp_blend_radius(blend, front, c0, c1, c2, c3);
    p.tag = front.tag;

    // A valid pixel stays, unless an ellipse lies in front of it.
    pushed = front.tag != 0 && (own.tag == 0 || front.z_max < own.z_min);
    missed = least > 1.0 && !seen && widest > STP_PUSH_WIDE && pyramid_level > 0;
    if (!pushed)
        p = own;
    return p;
}

// Finishes a pixel that none of the four coarse pixels reaches, from all that lie around them: the
// front of those whose ellipse reaches it, or `other`. Unless all four are valid, the pixel may lie
// beyond an outline: then a coarse pixel counts only if its depths do not meet those of the four's
// front. A pixel that is there is replaced only by a nearer one.
stp_pixel stp_push_further(ivec2 here, stp_pixel other)
{
    const int width = 2 * STP_PUSH_FURTHER + 1;
    vec2 centre = stp_pixel_centre(here, pyramid_level);
    vec3 ray = stp_ray(centre);
    ivec2 parent = here >> 1, side = 2 * (here & 1) - 1;
    stp_pixel own = stp_pixel_fine(here);
    stp_pixel c0 = stp_push_look(parent), c1 = stp_push_look(parent + ivec2(side.x, 0));
    stp_pixel c2 = stp_push_look(parent + ivec2(0, side.y)), c3 = stp_push_look(parent + side);
    stp_pixel near = stp_front(c0, c1, c2, c3), front = near;
    bool found = false, surrounded = c0.tag != 0 && c1.tag != 0 && c2.tag != 0 && c3.tag != 0;
    for (int i = 0; i < width * width; i++) {
        float q;
        stp_pixel c = stp_push_look(parent + ivec2(i % width, i / width) - STP_PUSH_FURTHER);
        c = stp_push_candidate(c, centre, ray, true, q);
        bool counts = surrounded || c.z_min > near.z_max || c.z_max < near.z_min;
        if (q <= 1.0 && counts && (!found || c.z_min < front.z_min)) {
            front = c;
            found = true;
        }
    }
    // Coarse pixels of one disc, equally deep, may differ in their source.
    front.tag = stp_tag_from(front.tag, pyramid_level + 1);
    return found && (own.tag == 0 || front.z_min < own.z_min) ? front : other;
}

stp_pixel stp_push(ivec2 here)
{
    ivec2 parent = here >> 1;
    ivec2 side = 2 * (here & 1) - 1;
    bool pushed, missed;
    stp_pixel p = stp_push_from(here, stp_push_look(parent), stp_push_look(parent + ivec2(side.x, 0)),
                                stp_push_look(parent + ivec2(0, side.y)), stp_push_look(parent + side), pushed, missed);
    for (; missed; missed = false) // software rasterisers skip a loop, but not the body of an if
        p = stp_push_further(here, p);
    return p;
}
