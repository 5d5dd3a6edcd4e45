// Projects a sample to a pixel. Needs patch.glsl.

// Unit ray from the eye through an eye-space position.
vec3 stp_ray_through(vec3 position)
{
    return STP_ORTHOGRAPHIC != 0 ? vec3(0.0, 0.0, -1.0) : normalize(position);
}

// Unit ray through window coordinates, pixels.
vec3 stp_ray(vec2 window)
{
    if (STP_ORTHOGRAPHIC != 0)
        return vec3(0.0, 0.0, -1.0);
    return normalize(vec3((window - centre.xy) / viewport.z, -1.0));
}

// Pixels covered at a depth by a world unit that faces the eye.
float stp_pixels_per_unit(float depth)
{
    return STP_ORTHOGRAPHIC != 0 ? viewport.z : viewport.z / depth;
}

// The place in eye space at window coordinates and a depth.
vec3 stp_window_place(vec2 window, float depth)
{
    vec2 off = (window - centre.xy) / viewport.z;
    return STP_ORTHOGRAPHIC != 0 ? vec3(off, -depth) : vec3(off, -1.0) * depth;
}

// Depth as the depth buffer stores it (1 at the near plane, 0 far away), and back.
float stp_depth_encode(float depth)
{
    return STP_ORTHOGRAPHIC != 0 ? 1.0 - depth / (2.0 * quality.w) : viewport.w / depth;
}

float stp_depth_decode(float z)
{
    return STP_ORTHOGRAPHIC != 0 ? (1.0 - z) * 2.0 * quality.w : viewport.w / z;
}

// Whether a sample is left out: it is marked, or of a hidden class.
bool stp_sample_left_out(uvec4 texel)
{
    bool out_of_class = false;
#if STP_HIDE_CLASSES
    uint class_id = texel.z >> 24;
    out_of_class = (hidden[class_id >> 7][class_id >> 5 & 3u] >> (class_id & 31u) & 1u) != 0u;
#endif
    return out_of_class || stp_sample_marked(texel);
}

// Whether a position, relative to the eye in world axes, lies behind one of the host's planes.
bool stp_behind_planes(vec3 from_eye)
{
    bool behind = false;
#if STP_PLANES
    for (int i = 0; i < STP_PLANES; i++)
        behind = behind || dot(planes[i].xyz, from_eye) + planes[i].w < 0.0;
#endif
    return behind;
}

// Whether a position lies outside the clip box or behind a plane.
bool stp_clipped(vec3 from_eye)
{
#if STP_CLIP
    return any(lessThan(from_eye, clip_min.xyz)) || any(greaterThan(from_eye, clip_max.xyz)) ||
           stp_behind_planes(from_eye);
#else
    return stp_behind_planes(from_eye);
#endif
}

// Whether the line of sight to any place in a ball passes through an opening of a closed surface.
// opening: its centre relative to the eye, and its radius. from_eye: the ball's centre relative to
// the eye.
bool stp_seen_through(vec4 opening, vec3 from_eye, float radius)
{
    float reach = opening.w + radius;
#if STP_ORTHOGRAPHIC
    vec3 off = opening.xyz - from_eye;
    float nearer = dot(off, stp_back());
    off -= nearer * stp_back();
    return nearer >= -reach && dot(off, off) <= reach * reach;
#else
    float part = clamp(dot(opening.xyz, from_eye) / max(dot(from_eye, from_eye), 1e-30), 0.0, 1.0);
    vec3 off = opening.xyz - part * from_eye;
    return dot(off, off) <= reach * reach;
#endif
}

// Sets of numbers below 128: bit i % 32 of word i / 32. Takes the least out of a set that has one.
int stp_set_take(inout uvec4 set)
{
    int word = set.x != 0u ? 0 : set.y != 0u ? 1 : set.z != 0u ? 2 : 3;
    uint bits = set.x != 0u ? set.x : set.y != 0u ? set.y : set.z != 0u ? set.z : set.w;
    uvec4 fewer = set & set - 1u;
    set = mix(set, fewer, equal(ivec4(0, 1, 2, 3), ivec4(word)));
    return 32 * word + findLSB(bits);
}

void stp_set_add(inout uvec4 set, int number)
{
    set |= mix(uvec4(0u), uvec4(1u << (number & 31)), equal(ivec4(0, 1, 2, 3), ivec4(number >> 5)));
}

// Whether the line of sight to a place passes through an opening of the set.
bool stp_place_opened(vec3 from_eye, uvec4 set)
{
#if STP_OPENINGS
    while (set != uvec4(0u))
        if (stp_seen_through(STP_OPENING(stp_set_take(set)), from_eye, 0.0))
            return true;
#endif
    return false;
}

// A cosine. If a sample is seen from behind at a flatter angle, it is drawn, since outlines need
// such samples, too. The same number is in runtime/cut/level_choice.c.
#define STP_CULL_COSINE 0.1

// Whether a sample is left out because its back is turned to the eye (docs/closed.md). set:
// stp_patch_openings of the patch, or stp_chunk_openings.
bool stp_culled(uvec4 texel, vec3 from_eye, uvec4 set)
{
    vec3 ray = STP_ORTHOGRAPHIC != 0 ? -stp_back() : from_eye, normal = stp_normal_direction(texel.z);
    float away = dot(normal, ray);
    bool culled = (modes.y & STP_BACKS_DRAWN) == 0 && stp_sample_back_hidden(texel) && away >= 0.0 &&
                  away * away >= STP_CULL_COSINE * STP_CULL_COSINE * dot(normal, normal) * dot(ray, ray);
    return culled && !stp_place_opened(from_eye, culled ? set : uvec4(0u));
}

// The pixel that holds a sample's centre, and its depth, from 1 at the near plane to 0 far away.
// Returns false if the sample is not drawn: behind the near plane, outside the picture or the clip
// box, left out, or culled. set: as for stp_culled. Runs for every sample, so it normalises
// nothing.
bool stp_place(uvec4 texel, vec3 origin, float step, uvec4 set, out ivec2 at, out float z)
{
    vec3 from_eye = stp_sample_position(texel, origin, step);
    vec3 position = stp_to_eye(from_eye);
    float depth = -position.z;
    vec2 window = centre.xy + position.xy * stp_pixels_per_unit(depth);
    vec2 pixel = floor(window);
    bool drawn = depth > viewport.w && all(greaterThanEqual(pixel, vec2(0.0))) &&
                 all(lessThan(pixel, viewport.xy));
    drawn = drawn && !stp_culled(texel, from_eye, set) && !stp_clipped(from_eye) &&
            !stp_sample_left_out(texel);
    at = ivec2(pixel);
    z = stp_depth_encode(depth);
    return drawn;
}

#define STP_ORDER_VERTEX 0u
#define STP_ORDER_SAMPLE 1u
#define STP_ORDER_SHAPE 2u

// Gives a depth its last two bits. Patch vertices are drawn first, then other samples, then
// segments and triangles. Each kind has its own last two bits, so depths of different kinds never
// tie, and the winner of a pixel does not depend on what was drawn in one pass.
float stp_depth_apart(float z, uint order)
{
    return uintBitsToFloat(floatBitsToUint(min(z, 0.99999976)) & ~3u | order);
}

// The clip position of the pixel's centre, so that no rasteriser's rounding moves the sample. If
// the sample is not drawn, the position lies outside the clip volume.
vec4 stp_project(uvec4 texel, vec3 origin, float step, uvec4 set)
{
    ivec2 at;
    float z;
    bool drawn = stp_place(texel, origin, step, set, at, z);
    return drawn ? vec4(vec2(2 * at + 1) / viewport.xy - 1.0, z, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
}

// The clip position of a place in eye space, for shapes that are rasterised.
vec4 stp_clip_position(vec3 position)
{
    float depth = -position.z;
    float w = STP_ORTHOGRAPHIC != 0 ? 1.0 : depth;
    float z = STP_ORTHOGRAPHIC != 0 ? stp_depth_encode(depth) : viewport.w;
    return vec4(2.0 * (centre.xy * w + position.xy * viewport.z) / viewport.xy - w, z, w);
}
