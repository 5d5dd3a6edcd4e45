// Emits the triangles of a patch, if patch.geom's rule chooses level 0. Instanced: each invocation
// emits its share.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "choose.glsl"
#include "corner.glsl"

#define STP_PATCH_MOST_TRIANGLES 21
#define STP_TRIANGLE_SHARE ((STP_PATCH_MOST_TRIANGLES + STP_INVOCATIONS - 1) / STP_INVOCATIONS)

layout(points, invocations = STP_INVOCATIONS) in;
layout(triangle_strip, max_vertices = 3 * STP_TRIANGLE_SHARE) out;

flat in uint patch_index[];

void main()
{
    stp_patch p;
    ivec4 levels;
    if (!stp_choose_shape(patch_index[0], STP_PATCH_TRIANGLES, p, levels))
        return;
    uint begin = uint(gl_InvocationID * STP_TRIANGLE_SHARE);
    uint end = min(p.count[0] / 3u, begin + uint(STP_TRIANGLE_SHARE));
    stp_packing packing = stp_packing_fetch(patch_index[0]);
    for (uint i = begin; i < end; i++) {
        uint first = p.first[0] + 3u * i;
        if (stp_sample_left_out(stp_sample_words(packing, first)))
            continue;
        for (uint k = first; k < first + 3u; k++) {
            stp_corner_set(stp_sample_position(stp_sample_words(packing, k), p.origin, p.step),
                           stp_name_of(patch_index[0], 0, 3u * i) | STP_NAME_TRIANGLE);
            EmitVertex();
        }
        EndPrimitive();
    }
}
