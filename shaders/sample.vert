// One vertex is one sample: the roads that choose levels on the CPU, or not at all.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"

layout(location = 0) in uvec4 texel;
layout(location = 1) in uint patch_of_chunk;

flat out uvec2 id; // sample, patch

void main()
{
    uint patch_index = first_patch + patch_of_chunk;
    vec4 lattice = uintBitsToFloat(texelFetch(patch_texture, int(patch_index) * STP_PATCH_TEXELS));
    id = uvec2(gl_VertexID, patch_index);
    gl_Position = stp_project(texel, lattice.xyz + chunk_offset, lattice.w);
}
