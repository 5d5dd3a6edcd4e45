// One vertex is one patch; the geometry shader does the rest.
#include "layout.glsl"

flat out uint patch_index;

void main()
{
    patch_index = uint(gl_VertexID);
    gl_Position = vec4(0.0);
}
