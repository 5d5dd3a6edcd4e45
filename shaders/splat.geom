// Chooses the levels of the patch's quarters, as patch.geom does, and emits their samples as splats.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "choose.glsl"
#include "palette.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "shape.glsl"
#include "sample_pixel.glsl"
#include "splat_out.glsl"

layout(points, invocations = STP_INVOCATIONS) in;
layout(points, max_vertices = STP_SHARE) out;

flat in uint patch_index[];

void main()
{
    uint of_patch = patch_index[0];
    stp_chunk chunk = stp_chunk_fetch(stp_patch_slot(of_patch));
    stp_patch p = stp_patch_fetch(of_patch, chunk.offset);
    stp_selection s = stp_select(p, stp_choose_levels(of_patch, p, chunk));
    uvec4 first = s.first - uvec4(0u, s.end.xyz);
    uint begin = uint(gl_InvocationID) * uint(STP_SHARE);
    uint end = min(s.end.w, begin + uint(STP_SHARE));
    for (uint i = begin; i < end; i++) {
        uint index = i + (i < s.end.x ? first.x : i < s.end.y ? first.y : i < s.end.z ? first.z : first.w);
        stp_splat_write(uvec2(index, of_patch));
        if (gl_Position.z <= 1.0)
            EmitVertex();
    }
}
