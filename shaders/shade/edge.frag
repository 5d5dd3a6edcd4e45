// Smooth edges: if a surface ends before a farther one, or before nothing, its pixels are covered
// only as far as the discs around them reach ("Smooth edges" in README.md). Branches are written as
// loops: software rasterisers skip a loop that no pixel of a block enters, but not the body of an
// if.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "pixel.glsl"

// A depth that is so many pixels deeper belongs to another surface.
#define STP_EDGE_STEP 64.0
// Least radius of a disc in pixels, and least cosine between its normal and the ray.
#define STP_EDGE_RADIUS 0.75
#define STP_EDGE_COSINE 1e-3
#define STP_EDGE_NONE -1e30
// A pixel keeps its nearest sample, at an outline the innermost. If discs have a radius below two
// pixels, samples that reach farther are lost; the smaller the discs, the more reach is lost.
#define STP_EDGE_LOST 0.4

layout(binding = 8) uniform sampler2D rough_picture;
layout(binding = 9) uniform sampler2D rough_depth; // 0 where nothing is

layout(location = 0) out vec4 picture;

// The depth that lies so many pixels deeper.
float stp_edge_deeper(float depth, float pixels)
{
    return depth + pixels / stp_pixels_per_unit(depth);
}

bool stp_edge_behind(float depth, float far)
{
    return depth <= 0.0 || depth > far;
}

// The offset, if it leads to something behind; else zero.
vec2 stp_edge_towards(ivec2 here, ivec2 last, ivec2 offset, float far)
{
    ivec2 there = clamp(here + offset, ivec2(0), last);
    return stp_edge_behind(texelFetch(rough_depth, there, 0).x, far) ? vec2(offset) : vec2(0.0);
}

// How far a disc reaches from this pixel's centre along `outward`. offset: from the pixel to the
// disc's centre.
float stp_edge_reach(stp_pixel c, vec2 offset, vec2 outward, vec3 ray)
{
    float inverse = 1.0 / max(c.radius * stp_pixels_per_unit(c.z_min), STP_EDGE_RADIUS);
    vec3 normal = stp_tag_tube(c.tag) ? -ray : c.normal;
    float k = dot(normal, ray);
    k = (k > 0.0 ? inverse : -inverse) / max(abs(k), STP_EDGE_COSINE);
    // On the disc, in its radii: from its centre to this pixel, and one pixel outward.
    vec3 from = ray * (k * dot(offset, normal.xy)) - vec3(offset, 0.0) * inverse;
    vec3 step = vec3(outward, 0.0) * inverse - ray * (k * dot(outward, normal.xy));
    float a = dot(step, step), b = dot(from, step);
    float root = b * b - a * (dot(from, from) - 1.0);
    float lost = STP_EDGE_LOST * max(0.0, 1.0 - 0.5 / inverse);
    return root >= 0.0 ? (sqrt(root) - b) / a + lost : STP_EDGE_NONE;
}

// The farthest reach of the discs of this pixel's surface, with depths between near and far: of the
// projected samples around the pixel, and of the four pixels that push would take, if there are
// any.
float stp_edge_farthest(ivec2 here, ivec2 last, vec2 outward, float near, float far)
{
    vec3 ray = stp_ray(gl_FragCoord.xy);
    float reach = STP_EDGE_NONE;
    // One loop, since each loop costs all pixels, entered or not.
    for (int i = 0; i < 9 + 4 * pyramid_level; i++) {
        bool coarse = i >= 9;
        int k = i - 9;
        ivec2 side = (2 * (here & 1) - 1) * ivec2(k & 1, k >> 1);
        ivec2 at = coarse ? clamp((here >> 1) + side, ivec2(0), read_size - 1)
                          : clamp(here + ivec2(i % 3, i / 3) - 1, ivec2(0), last);
        uvec4 shape = coarse ? texelFetch(coarse_shape, at, 0) : texelFetch(fine_shape, at, 0);
        uvec4 paint = coarse ? texelFetch(coarse_paint, at, 0) : texelFetch(fine_paint, at, 0);
        stp_pixel c = stp_pixel_unpack(shape, paint);
        vec2 offset = stp_pixel_centre(at, coarse ? 1 : 0) - gl_FragCoord.xy + c.d;
        bool same = c.tag != 0 && c.z_min > near && c.z_min < far;
        float end = stp_edge_reach(c, offset, outward, ray);
        reach = same ? max(reach, end) : reach;
    }
    return reach;
}

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy), last = ivec2(viewport.xy) - 1;
    picture = texelFetch(rough_picture, here, 0);
    float depth = texelFetch(rough_depth, here, 0).x;
    float far = stp_edge_deeper(depth, STP_EDGE_STEP), near = stp_edge_deeper(depth, -STP_EDGE_STEP);
    vec2 sum = vec2(0.0);
    for (bool covered = depth > 0.0; covered; covered = false) {
        sum += stp_edge_towards(here, last, ivec2(2, 0), far) + stp_edge_towards(here, last, ivec2(-2, 0), far);
        sum += stp_edge_towards(here, last, ivec2(0, 2), far) + stp_edge_towards(here, last, ivec2(0, -2), far);
        sum += stp_edge_towards(here, last, ivec2(1, 1), far) + stp_edge_towards(here, last, ivec2(-1, -1), far);
        sum += stp_edge_towards(here, last, ivec2(-1, 1), far) + stp_edge_towards(here, last, ivec2(1, -1), far);
    }
    for (bool edge = dot(sum, sum) > 0.0; edge; edge = false) {
        vec2 outward = normalize(sum);
        float reach = stp_edge_farthest(here, last, outward, near, far);
        float share = reach > STP_EDGE_NONE ? clamp(0.5 + reach, 0.0, 1.0) : 1.0;
        ivec2 beyond = clamp(here + ivec2(round(2.0 * outward)), ivec2(0), last);
        bool behind = stp_edge_behind(texelFetch(rough_depth, beyond, 0).x, far);
        vec4 ground = behind ? texelFetch(rough_picture, beyond, 0) : vec4(0.0);
        picture = mix(ground, picture, share);
    }
}
