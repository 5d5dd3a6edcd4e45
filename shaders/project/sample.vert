// One vertex is one sample, by its name: of patches whose level the CPU chose, or of all patches.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"

layout(location = 4) uniform bool vertices; // all samples are patch vertices (level 3)

flat out uint id; // of the sample

void main()
{
    id = uint(gl_VertexID);
    uint patch_index = stp_name_patch(id), slot = stp_patch_slot(patch_index);
    vec4 lattice = stp_lattice_fetch(patch_index, stp_chunk_fetch(slot).offset);
    uvec4 texel = stp_sample_words(stp_packing_fetch(patch_index), stp_name_number(id, stp_patch_count(patch_index)));
    gl_Position = stp_project(texel, lattice.xyz, lattice.w, stp_chunk_openings(slot));
    gl_Position.z = stp_depth_apart(gl_Position.z, vertices ? STP_ORDER_VERTEX : STP_ORDER_SAMPLE);
}
