// Shapes and maps after compute shaders have drawn the samples, and left their depths in an image
// (scatter.glsl). Needs nothing.

layout(location = 5) uniform bool scattered;
layout(r32ui, binding = 0) uniform uimage2D nearest_depth;

// Whether a sample is nearer than this depth. If not, the depth is left in place of the sample's.
bool stp_scattered_before(float z)
{
    uint bits = floatBitsToUint(z);
    return scattered && imageAtomicMax(nearest_depth, ivec2(gl_FragCoord.xy), bits) > bits;
}
