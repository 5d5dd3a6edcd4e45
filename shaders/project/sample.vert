// One vertex is one sample, by its name: of patches whose level the CPU chose, or of all patches; with STP_VERTICES a
// patch vertex (level 3).
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"

flat out uint id; // of the sample

void main()
{
    id = uint(gl_VertexID);
    uint patch_index = stp_name_patch(id), slot = stp_patch_slot(patch_index);
    vec4 lattice = stp_lattice_fetch(patch_index, stp_chunk_fetch(slot).offset);
#if STP_VERTICES
    const uint order = STP_ORDER_VERTEX;
    uvec4 texel = stp_vertex_words(stp_patch_samples(patch_index));
#else
    const uint order = STP_ORDER_SAMPLE;
    uvec4 texel = stp_sample_words(stp_packing_fetch(patch_index), stp_name_number(id, stp_patch_count(patch_index)));
#endif
    gl_Position = stp_project(texel, lattice.xyz, lattice.w, stp_chunk_openings(slot));
    gl_Position.z = stp_depth_apart(gl_Position.z, order);
}
