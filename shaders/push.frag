// Coarse to fine: pixels that are invalid or hidden behind nearer ellipses are interpolated from
// four pixels of the next coarser level (biquadratic B-spline weights, PBG07; times the ellipse's
// Gaussian, CG08). Reads the pulled level l as fine and the finished level l + 1 as coarse, writes
// the finished level l.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "pixel.glsl"
#include "pixel_out.glsl"
#include "ellipse.glsl"
#include "blend.glsl"

// The part of the coarse level that was written: x0, y0, x1, y1. The rest is empty.
layout(location = 4) uniform ivec4 coarse_area;

// A coarse pixel as seen from `centre`: invalid where its ellipse does not reach. The weight is the
// B-spline's, times the ellipse's kernel.
stp_pixel stp_push_candidate(ivec2 p, vec2 centre, inout float weight)
{
    stp_pixel c = stp_pixel_unpack(texelFetch(coarse_shape, p, 0), texelFetch(coarse_depth, p, 0),
                                   texelFetch(coarse_colour, p, 0));
    vec2 middle = stp_pixel_centre(p, pyramid_level + 1) + c.d;
    c.d = middle - centre;
    float q = stp_ellipse(c, middle, -c.d);
    bool inside = all(greaterThanEqual(p, coarse_area.xy)) && all(lessThan(p, coarse_area.zw));
    c.tag = inside && q <= 1.0 ? c.tag : 0;
    weight *= STP_BOX != 0 ? 1.0 : exp(-0.5 * min(q, 1.0));
    return c;
}

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    ivec2 parent = here >> 1;
    ivec2 side = 2 * (here & 1) - 1;
    vec2 centre = stp_pixel_centre(here, pyramid_level);
    vec4 weights = vec4(9.0, 3.0, 3.0, 1.0) / 16.0;
    stp_pixel c0 = stp_push_candidate(parent, centre, weights.x);
    stp_pixel c1 = stp_push_candidate(parent + ivec2(side.x, 0), centre, weights.y);
    stp_pixel c2 = stp_push_candidate(parent + ivec2(0, side.y), centre, weights.z);
    stp_pixel c3 = stp_push_candidate(parent + side, centre, weights.w);
    stp_pixel front = stp_front(c0, c1, c2, c3);
    stp_blend blend = stp_blend_four(front, c0, c1, c2, c3, weights);
    stp_pixel p = blend.sum;
    p.radius = sqrt(p.radius);
    p.tag = front.tag;

    // Valid pixels stay, unless they lie behind their parent's interval and an ellipse in front.
    stp_pixel own = stp_pixel_unpack(texelFetch(fine_shape, here, 0), texelFetch(fine_depth, here, 0),
                                     texelFetch(fine_colour, here, 0));
    bool occluded = texelFetch(coarse_colour, parent, 0).a != 0.0 &&
                    own.z_min > texelFetch(coarse_depth, parent, 0).y && front.z_max < own.z_min;
    bool keep = front.tag == 0 || (own.tag != 0 && !occluded);
    if (keep)
        p = own;
    stp_pixel_write(p);
}
