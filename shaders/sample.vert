// One vertex is one sample: the roads that choose levels on the CPU, or not at all.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"

layout(location = 0) in uvec4 texel;
layout(location = 1) in uint patch_index;

flat out uint id; // of the sample

void main()
{
    vec4 lattice = uintBitsToFloat(texelFetch(patch_texture, int(patch_index) * STP_PATCH_TEXELS));
    id = uint(gl_VertexID);
    gl_Position = stp_project(texel, lattice.xyz + chunk_offset, lattice.w);
}
