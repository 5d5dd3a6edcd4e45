// Names the segment or triangle that a pixel holds.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"

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
    nearest = id;
    gl_FragDepth = stp_depth_apart(gl_FragCoord.z, STP_ORDER_SHAPE);
}
