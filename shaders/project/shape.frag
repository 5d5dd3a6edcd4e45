// Names the segment or triangle that a pixel holds.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"

flat in uint id;
#if STP_PLANES
in vec3 place;
#endif

layout(location = 0) out uint nearest;

// Compute shaders have drawn the samples, and left their depths here (scatter.glsl).
layout(location = 1) uniform bool scattered;
layout(r32ui, binding = 0) uniform uimage2D nearest_depth;

void main()
{
#if STP_PLANES
    if (stp_behind_planes(place))
        discard;
#endif
    float z = stp_depth_apart(gl_FragCoord.z, STP_ORDER_SHAPE);
    uint bits = floatBitsToUint(z);
    if (scattered && imageAtomicMax(nearest_depth, ivec2(gl_FragCoord.xy), bits) > bits)
        discard;
    nearest = id;
    gl_FragDepth = z;
}
