// Fine to coarse: a pixel of level l out of the four of level l - 1 under it (PBG07; the ellipse
// test is CG08's). Reads level l - 1 as fine, writes level l.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "pixel.glsl"
#include "pixel_out.glsl"
#include "ellipse.glsl"

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec2 centre = stp_pixel_centre(here, pyramid_level);
    ivec2 size = textureSize(fine_colour, 0);
    stp_pixel candidate[4];
    int front = -1;
    for (int i = 0; i < 4; i++) {
        ivec2 p = 2 * here + ivec2(i & 1, i >> 1);
        candidate[i].tag = 0;
        if (any(greaterThanEqual(p, size)))
            continue;
        vec4 colour = texelFetch(fine_colour, p, 0);
        if (colour.a == 0.0)
            continue;
        candidate[i] = stp_pixel_unpack(texelFetch(fine_shape, p, 0), texelFetch(fine_depth, p, 0),
                                        colour);
        vec2 middle = stp_pixel_centre(p, pyramid_level - 1) + candidate[i].d;
        if (modes.z == 0 && stp_ellipse(candidate[i], middle, centre - middle) > 1.0)
            candidate[i].tag = 0;
        candidate[i].d = middle - centre;
        if (candidate[i].tag != 0 && (front < 0 || candidate[i].z_min < candidate[front].z_min))
            front = i;
    }
    if (front < 0) {
        stp_pixel_write(stp_pixel_invalid());
        return;
    }
    stp_pixel first = candidate[front];
    stp_pixel sum = stp_pixel(vec3(0.0), 0.0, first.z_min, first.z_max, vec2(0.0), vec3(0.0),
                              stp_tag_from(first.tag, pyramid_level));
    float count = 0.0;
    for (int i = 0; i < 4; i++) {
        stp_pixel c = candidate[i];
        if (c.tag == 0 || c.z_min > first.z_max)
            continue;
        bool turn = (stp_tag_two_sided(first.tag) || stp_tag_two_sided(c.tag)) &&
                    dot(c.normal, first.normal) < 0.0;
        sum.normal += turn ? -c.normal : c.normal;
        sum.radius += c.radius;
        sum.z_max = max(sum.z_max, c.z_max);
        sum.d += c.d;
        sum.colour += c.colour;
        count += 1.0;
    }
    float norm = length(sum.normal);
    sum.normal = norm > 0.0 ? sum.normal / norm : first.normal;
    sum.radius /= count;
    sum.d /= count;
    sum.colour /= count;
    stp_pixel_write(sum);
}
