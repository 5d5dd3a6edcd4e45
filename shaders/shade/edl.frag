// Eye-dome lighting (Boucheny 2009): darkens a pixel by how much nearer its neighbours are, from
// depths alone. Multiplied into the picture.
#include "layout.glsl"

// The darkening by one pixel of depth difference at strength 1.
#define STP_EDL_SHARE 0.15

layout(binding = 4) uniform sampler2D picture_depth; // 0 where nothing is

layout(location = 0) out vec4 dimmed;

// How many pixels `depth` lies behind `other`. In perspective by the logarithm, so that a slope is
// equally dark far away and near by.
float stp_edl_behind(float depth, float other)
{
    float behind = STP_ORTHOGRAPHIC != 0 ? depth - other : log(depth / other);
    return other > 0.0 ? max(0.0, viewport.z * behind) : 0.0;
}

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy), last = ivec2(viewport.xy) - 1;
    float depth = texelFetch(picture_depth, here, 0).x;
    float sum = 0.0;
    for (int y = -1; y <= 1; y++)
        for (int x = -1; x <= 1; x++) {
            ivec2 there = clamp(here + ivec2(x, y), ivec2(0), last);
            sum += stp_edl_behind(depth, texelFetch(picture_depth, there, 0).x);
        }
    float response = depth > 0.0 ? sum / 8.0 : 0.0;
    dimmed = vec4(vec3(exp(-colour_range.w * STP_EDL_SHARE * response)), 1.0);
}
