// A corner of a triangle of a grid (square.comp).
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "square.glsl"
#include "pieces.glsl"
#include "corner.glsl"

layout(binding = 9) uniform usamplerBuffer triangle_texture;
layout(binding = 10) uniform samplerBuffer place_texture;

void main()
{
    uint triangle = uint(gl_VertexID) / 3u, corner = uint(gl_VertexID) % 3u, square = triangle / STP_SQUARE_TRIANGLES;
    uint name = texelFetch(triangle_texture, int(triangle)).x;
    // A cell has the samples 0, 1, 2, 3; its two triangles are 0, 1, 2 and 2, 1, 3.
    if ((name & STP_SQUARE_SECOND) != 0u)
        corner = corner == 2u ? 3u : 2u - corner;
    ivec2 at = stp_square_at(name >> STP_NAME_PLACE_SHIFT & 63u) + ivec2(corner & 1u, corner >> 1);
    uint place = (name & STP_SQUARE_WHOLE) != 0u ? uint(9 * at.y + at.x)
                                                 : uint(STP_SQUARE_CELLS) + (name >> STP_NAME_SQUARE_SHIFT << 2) + corner;
    uint low = name & (1u << STP_NAME_SQUARE_SHIFT) - 1u;
    stp_corner_set(texelFetch(place_texture, int(square * STP_SQUARE_PLACES + place)).xyz,
                   STP_NAME_SQUARE | squares.x + square << STP_NAME_SQUARE_SHIFT | low);
}
