// Chooses the level of a strip's patch, as patch.geom does, and emits the polyline through that
// level's vertices (MKC08, section 4.1). Leaves out ribbons wider than a pixel, which
// strip_wide.geom emits. Instanced: each invocation emits its share of the segments.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "choose.glsl"
#include "corner.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "shape.glsl"

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
    vec4 lattice = vec4(p.origin, p.step);
    stp_packing packing = stp_packing_fetch(patch_index[0]);
    uint to_name = stp_name_of(patch_index[0], levels.x, 0u) - p.first[levels.x];
    for (uint i = first; i < end; i++) {
        uvec4 texel = stp_sample_words(packing, i);
        // The rasteriser takes a segment's name from its last vertex; the name is the first
        // vertex's.
        stp_corner_set(stp_sample_position(texel, p.origin, p.step), i - 1u + to_name | STP_NAME_SEGMENT);
        EmitVertex();
        bool wide = i + 1u < end && stp_ribbon_wide(stp_disc_decode(texel, p.origin, p.step),
                                                    stp_vertex_fetch(packing, i + 1u, lattice));
        if (stp_sample_left_out(texel) || wide) // leaves out the next segment
            EndPrimitive();
    }
}
