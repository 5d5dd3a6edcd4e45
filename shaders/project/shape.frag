// Names the segment or triangle that a pixel holds.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"

flat in uint id;

layout(location = 0) out uint nearest;

void main()
{
    nearest = id;
    gl_FragDepth = stp_depth_apart(gl_FragCoord.z, STP_ORDER_SHAPE);
}
