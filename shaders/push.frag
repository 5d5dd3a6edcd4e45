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

// The part of the coarse level that was written: x0, y0, x1, y1. The rest is empty.
layout(location = 4) uniform ivec4 coarse_area;

// A coarse pixel as seen from `centre`: invalid where its ellipse does not reach; q returned.
float stp_push_candidate(ivec2 p, vec2 centre, out stp_pixel c)
{
    c.tag = 0;
    if (any(lessThan(p, coarse_area.xy)) || any(greaterThanEqual(p, coarse_area.zw)))
        return 0.0;
    vec4 colour = texelFetch(coarse_colour, p, 0);
    if (colour.a == 0.0)
        return 0.0;
    c = stp_pixel_unpack(texelFetch(coarse_shape, p, 0), texelFetch(coarse_depth, p, 0), colour);
    vec2 middle = stp_pixel_centre(p, pyramid_level + 1) + c.d;
    float q = stp_ellipse(c, middle, centre - middle);
    c.d = middle - centre;
    if (q > 1.0)
        c.tag = 0;
    return q;
}

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec4 own_shape = texelFetch(fine_shape, here, 0);
    vec4 own_depth = texelFetch(fine_depth, here, 0);
    vec4 own_colour = texelFetch(fine_colour, here, 0);
    out_shape = own_shape;
    out_depth = own_depth;
    out_colour = own_colour;

    ivec2 parent = here >> 1;
    bool valid = own_colour.a != 0.0;
    if (valid && (texelFetch(coarse_colour, parent, 0).a == 0.0 ||
                  own_depth.x <= texelFetch(coarse_depth, parent, 0).y))
        return;

    ivec2 side = 2 * (here & 1) - 1;
    vec2 centre = stp_pixel_centre(here, pyramid_level);
    stp_pixel candidate[4];
    float weight[4];
    int front = -1;
    for (int i = 0; i < 4; i++) {
        ivec2 away = ivec2(i & 1, i >> 1);
        float q = stp_push_candidate(parent + side * away, centre, candidate[i]);
        weight[i] = (away.x == 0 ? 0.75 : 0.25) * (away.y == 0 ? 0.75 : 0.25) *
                    (modes.z == 0 ? exp(-0.5 * q) : 1.0);
        if (candidate[i].tag != 0 && (front < 0 || candidate[i].z_min < candidate[front].z_min))
            front = i;
    }
    if (front < 0 || (valid && candidate[front].z_max >= own_depth.x))
        return;

    stp_pixel first = candidate[front];
    stp_pixel sum = stp_pixel(vec3(0.0), 0.0, 0.0, 0.0, vec2(0.0), vec3(0.0), first.tag);
    float total = 0.0;
    for (int i = 0; i < 4; i++) {
        stp_pixel c = candidate[i];
        if (c.tag == 0 || c.z_min > first.z_max)
            continue;
        float w = weight[i];
        bool turn = (stp_tag_two_sided(first.tag) || stp_tag_two_sided(c.tag)) &&
                    dot(c.normal, first.normal) < 0.0;
        sum.normal += turn ? -w * c.normal : w * c.normal;
        sum.radius += w * c.radius;
        sum.z_min += w * c.z_min;
        sum.z_max += w * c.z_max;
        sum.d += w * c.d;
        sum.colour += w * c.colour;
        total += w;
    }
    float norm = length(sum.normal);
    sum.normal = norm > 0.0 ? sum.normal / norm : first.normal;
    sum.radius /= total;
    sum.z_min /= total;
    sum.z_max /= total;
    sum.d /= total;
    sum.colour /= total;
    stp_pixel_write(sum);
}
