// A corner of a piece of a grid (square.comp).
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "corner.glsl"

layout(location = 0) in vec3 from_eye;
layout(location = 1) in uint name;

void main()
{
    stp_corner_set(from_eye, name);
}
