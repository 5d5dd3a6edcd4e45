// Names the segment or triangle that a pixel holds.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "scattered.glsl"

flat in uint id;
#if STP_PLANES
in vec3 place;
#endif

layout(location = 0) out uint nearest;

void main()
{
#if STP_PLANES
    if (stp_behind_planes(place))
        discard;
#endif
    float z = stp_depth_apart(gl_FragCoord.z, STP_ORDER_SHAPE);
    if (stp_scattered_before(z))
        discard;
    nearest = id;
    gl_FragDepth = z;
}
