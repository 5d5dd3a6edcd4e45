// Fades level changes. If a pixel's surface was drawn at another level in the last frame, the pixel
// keeps the difference from what was shown, and loses a share of it each frame ("Fading" in
// README.md).
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"

// A difference below half of this step is dropped.
#define STP_FADE_STEP (1.0 / 255.0)
// Two depths belong to the same surface if they differ by at most this share.
#define STP_FADE_DEPTH 0.01

layout(binding = 4) uniform sampler2D fresh_picture;
layout(binding = 5) uniform sampler2D fresh_depth;
layout(binding = 6) uniform usampler2D fresh_mark; // the surface's depth in the tree and level
layout(binding = 7) uniform sampler2D last_picture; // as shown
layout(binding = 8) uniform sampler2D last_depth;
layout(binding = 9) uniform usampler2D last_mark;
layout(binding = 10) uniform sampler2D last_difference;

layout(location = 8) uniform float kept;       // share of a difference that stays; 0: no last frame
layout(location = 9) uniform vec3 way;         // the eye's position minus that of the last frame
layout(location = 10) uniform mat3 last_axes;  // rows: right, up, back
layout(location = 11) uniform float last_f;

layout(location = 0) out vec4 picture;
layout(location = 1) out float depth;
layout(location = 2) out uint mark;
layout(location = 3) out vec4 difference;

// Where the surface at a pixel was in the last frame: window coordinates and depth.
vec3 stp_last_window(vec2 window, float at_depth)
{
    const bool orthographic = STP_ORTHOGRAPHIC != 0;
    vec2 off = (window - centre.xy) / viewport.z * (orthographic ? 1.0 : at_depth);
    vec3 eye = last_axes * (stp_from_eye(vec3(off, -at_depth)) + way);
    float scale = orthographic ? last_f : last_f / max(-eye.z, 1e-30);
    return vec3(centre.xy + eye.xy * scale, -eye.z);
}

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    picture = texelFetch(fresh_picture, here, 0);
    depth = texelFetch(fresh_depth, here, 0).x;
    mark = texelFetch(fresh_mark, here, 0).x;
    difference = vec4(0.0);
    if (depth <= 0.0 || kept <= 0.0)
        return;
    vec3 was = stp_last_window(gl_FragCoord.xy, depth);
    ivec2 there = ivec2(floor(was.xy));
    if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(vec2(there), viewport.xy)))
        return;
    float was_depth = texelFetch(last_depth, there, 0).x;
    if (was_depth <= 0.0 || abs(was_depth - was.z) > STP_FADE_DEPTH * was.z)
        return;
    bool changed = texelFetch(last_mark, there, 0).x != mark;
    vec3 left = changed ? texelFetch(last_picture, there, 0).rgb - picture.rgb
                        : texelFetch(last_difference, there, 0).rgb;
    left *= kept;
    if (all(lessThan(abs(left), vec3(0.5 * STP_FADE_STEP))))
        return;
    difference = vec4(left, 0.0);
    picture.rgb = clamp(picture.rgb + left, 0.0, 1.0);
}
