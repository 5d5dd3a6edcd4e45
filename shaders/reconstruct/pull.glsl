// Pull, fine to coarse: makes a pixel of level l from the four of level l - 1 under it (MKC07).
// MKC08 adds the ellipse test, Mar08 the test which pixels go on to level l. Needs pixel.glsl,
// ellipse.glsl, blend.glsl; if STP_TEMPLATE, template.glsl.

// Pixel p of level l - 1 as seen from the centre of a pixel of level l. Invalid if its ellipse does
// not reach that centre, if the pixel stays on its level (templates), or if it lies outside the
// picture.
stp_pixel stp_pull_candidate(stp_pixel c, ivec2 p, int level, bool inside, vec2 centre, vec3 ray)
{
    vec2 middle = stp_pixel_centre(p, level - 1) + c.d;
    c.d = middle - centre;
#if STP_TEMPLATE
    bool reaches = stp_template_carries(c, level - 1);
#else
    bool reaches = STP_BOX != 0 ? c.radius > 0.0 : stp_ellipse(c, ray, -c.d) <= 1.0;
#endif
    c.tag = reaches && inside ? c.tag : 0;
    return c;
}

// Pixel `here` of a level, from the pixels 2 here + (0,0), (1,0), (0,1), (1,1) of the finer level
// of that size.
stp_pixel stp_pull(ivec2 here, int level, ivec2 size, stp_pixel f0, stp_pixel f1, stp_pixel f2, stp_pixel f3)
{
    vec2 centre = stp_pixel_centre(here, level);
    vec3 ray = stp_ray(centre);
    bvec2 more = lessThan(2 * here + 1, size);
    bool there = all(lessThan(2 * here, size));
    stp_pixel c0 = stp_pull_candidate(f0, 2 * here, level, there, centre, ray);
    stp_pixel c1 = stp_pull_candidate(f1, 2 * here + ivec2(1, 0), level, there && more.x, centre, ray);
    stp_pixel c2 = stp_pull_candidate(f2, 2 * here + ivec2(0, 1), level, there && more.y, centre, ray);
    stp_pixel c3 = stp_pull_candidate(f3, 2 * here + ivec2(1, 1), level, all(more), centre, ray);
    stp_pixel front = stp_front(c0, c1, c2, c3);
    stp_blend blend = stp_blend_four(front, c0, c1, c2, c3, vec4(1.0));

    stp_pixel p = blend.sum;
#if STP_GRID && !STP_BOX && !STP_TEMPLATE
    p.radius = sqrt(p.radius); // no hole closes by discs that grow
#elif !STP_BOX
    // The disc with the second moment of the discs it replaces: R^2 = mean r^2 + 2 variance. A line
    // grows no wider.
    float unit = 1.0 / max(stp_pixels_per_unit(front.z_min), 1e-30);
    float variance = stp_tag_line(front.tag) ? 0.0 : max(0.0, blend.distance - dot(p.d, p.d)) * unit * unit;
    p.radius = sqrt(p.radius + 2.0 * variance);
#endif
    p.z_min = front.z_min;
    p.z_max = blend.farthest;
    p.tag = stp_tag_from(front.tag, level);
    if (front.tag == 0)
        p = stp_pixel_invalid();
    return p;
}

// Pulls from level l - 1, which is read as fine.
stp_pixel stp_pull_fine(ivec2 here, int level)
{
    ivec2 p = 2 * here;
    return stp_pull(here, level, read_size, stp_pixel_fine(p), stp_pixel_fine(p + ivec2(1, 0)),
                    stp_pixel_fine(p + ivec2(0, 1)), stp_pixel_fine(p + ivec2(1, 1)));
}
