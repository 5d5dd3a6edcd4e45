// Chooses the level of a strip's patch, as patch.geom does, and emits the polyline through the vertices that stay
// (CG08, section 4.1). Instanced: each invocation emits its share of the segments.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "choose.glsl"
#include "corner.glsl"

layout(points, invocations = STP_INVOCATIONS) in;
layout(line_strip, max_vertices = STP_SHARE + 1) out;

flat in uint patch_index[];

void main()
{
    stp_patch p;
    ivec4 levels;
    if (!stp_choose_shape(patch_index[0], STP_PATCH_STRIP, p, levels))
        return;
    stp_selection s = stp_select(p, levels);
    uint first = s.first.x + uint(gl_InvocationID) * uint(STP_SHARE);
    uint end = min(s.first.x + s.end.w, first + uint(STP_SHARE) + 1u);
    for (uint i = first; i < end; i++) {
        uvec4 texel = texelFetch(object_texture, int(i));
        // The last vertex of a segment names it, by its first.
        stp_corner_emit(stp_sample_position(texel, p.origin, p.step), i - 1u | STP_NAME_SEGMENT);
        if (stp_class_hidden(texel.z >> 24)) // the next segment is
            EndPrimitive();
    }
}
