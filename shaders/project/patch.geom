// Chooses the levels of a patch's quarters and emits their samples from the Object Texture (Mar08,
// "Object Texture"). Instanced: each invocation emits its share.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "choose.glsl"

layout(points, invocations = STP_INVOCATIONS) in;
layout(points, max_vertices = STP_SHARE) out;

flat in uint patch_index[];
flat out uint id; // of the sample

void main()
{
    stp_patch p;
    ivec4 levels;
    if (!stp_choose_shape(patch_index[0], 0u, p, levels)) // strip.geom or triangle.geom draws it
        return;
    stp_selection s = stp_select(p, levels);
    uvec4 before = uvec4(0u, s.end.xyz), first = s.first - before, name = stp_selection_names(s, patch_index[0], p, levels) - before;
    uint begin = uint(gl_InvocationID) * uint(STP_SHARE);
    uint end = min(s.end.w, begin + uint(STP_SHARE));
    uint slot = stp_patch_slot(patch_index[0]);
    uvec4 set = stp_patch_openings(p, slot);
    stp_packing packing = stp_packing_fetch(patch_index[0]);
    for (uint i = begin; i < end; i++) {
        int q = i < s.end.x ? 0 : i < s.end.y ? 1 : i < s.end.z ? 2 : 3;
        vec4 position = stp_project(stp_sample_words(packing, i + first[q]), p.origin, p.step, set);
        if (position.z > 1.0)
            continue;
        position.z = stp_depth_apart(position.z, STP_ORDER_SAMPLE);
        gl_Position = position;
        id = i + name[q];
        EmitVertex();
    }
}
