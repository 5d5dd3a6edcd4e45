// Emits segments with their width. Chooses levels as strip.geom does, and emits ribbons wider than
// a pixel as flat pieces. With splats, emits any other segment as a rectangle of the image around
// it; shape_front.frag keeps the part that the segment's discs cover.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "choose.glsl"
#include "corner.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "shape.glsl"

#define STP_WIDE_INVOCATIONS 4
#define STP_WIDE_SHARE (STP_SHARE * STP_INVOCATIONS / STP_WIDE_INVOCATIONS)

layout(points, invocations = STP_WIDE_INVOCATIONS) in;
layout(triangle_strip, max_vertices = 4 * STP_WIDE_SHARE) out;

flat in uint patch_index[];

#if STP_SPLAT
// How far the image of a ball reaches at most from that of its centre, pixels, and a pixel more.
float stp_ball_reach(vec3 position, float radius)
{
    if (STP_ORTHOGRAPHIC != 0)
        return radius * viewport.z + 1.0;
    float depth = -position.z;
    return viewport.z * radius * length(position) / (depth * max(depth - radius, viewport.w)) + 1.0;
}

void stp_rectangle_emit(stp_disc a, stp_disc b, uint name)
{
    if (max(-a.position.z, -b.position.z) <= viewport.w)
        return;
    vec2 part = stp_segment_part(a, b);
    vec3 ends[2] = vec3[2](mix(a.position, b.position, part.x), mix(a.position, b.position, part.y));
    vec2 way = stp_window_of(ends[1]) - stp_window_of(ends[0]);
    vec2 along = dot(way, way) > 0.0 ? normalize(way) : vec2(1.0, 0.0);
    float reach = max(stp_ball_reach(ends[0], mix(a.radius, b.radius, part.x)),
                      stp_ball_reach(ends[1], mix(a.radius, b.radius, part.y)));
    for (int k = 0; k < 4; k++) {
        vec2 aside = vec2(-along.y, along.x) * ((k & 1) == 0 ? -reach : reach);
        vec2 offset = aside + along * (k < 2 ? -reach : reach);
        vec4 end = stp_clip_position(ends[k >> 1]);
        gl_Position = vec4(end.xy + 2.0 * offset / viewport.xy * end.w, 0.5 * end.w, end.w); // between the planes
#if STP_CLIP
        for (int plane = 0; plane < 6; plane++)
            gl_ClipDistance[plane] = 1.0; // what is left is asked for each pixel
#endif
#if STP_PLANES
        place = vec3(0.0); // likewise
#endif
        id = name;
        EmitVertex();
    }
    EndPrimitive();
}
#endif

// position: in eye space.
void stp_ribbon_corner(vec3 position, uint name)
{
    stp_corner_set(stp_from_eye(position), name);
    EmitVertex();
}

void stp_ribbon_emit(stp_ribbon r, uint name)
{
    stp_ribbon_corner(r.a.position - r.a_half, name);
    stp_ribbon_corner(r.a.position + r.a_half, name);
    stp_ribbon_corner(r.b.position - r.b_half, name);
    stp_ribbon_corner(r.b.position + r.b_half, name);
    EndPrimitive();
}

void main()
{
    stp_patch p;
    ivec4 levels;
    if (!stp_choose_shape(patch_index[0], STP_PATCH_STRIP, p, levels))
        return;
    stp_selection s = stp_select(p, levels);
    uvec2 ends = uvec2(s.first.x, s.first.x + s.end.w);
    uint first = ends.x + uint(gl_InvocationID * STP_WIDE_SHARE);
    uint end = min(ends.y - 1u, first + uint(STP_WIDE_SHARE));
    vec4 lattice = vec4(p.origin, p.step);
    stp_packing packing = stp_packing_fetch(patch_index[0]);
    uint to_name = stp_name_of(patch_index[0], levels.x, 0u) - p.first[levels.x];
    for (uint i = first; i < end; i++) {
        if (stp_sample_left_out(stp_sample_words(packing, i)))
            continue;
        stp_disc a = stp_vertex_fetch(packing, i, lattice), b = stp_vertex_fetch(packing, i + 1u, lattice);
        if (stp_ribbon_wide(a, b))
            stp_ribbon_emit(stp_ribbon_between(a, b, packing, i, ends, lattice), i + to_name | STP_NAME_RIBBON);
#if STP_SPLAT
        else
            stp_rectangle_emit(a, b, i + to_name | STP_NAME_SEGMENT);
#endif
    }
}
