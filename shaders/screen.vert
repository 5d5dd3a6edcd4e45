// Corners of the tiles to draw, window pixels, in the order of runtime/tiles.c.
layout(location = 0) in vec2 corner;

layout(location = 5) uniform vec3 tile_to_clip; // z: pixels that tiles are larger on each side

const vec2 outwards[6] = vec2[](vec2(-1.0, -1.0), vec2(1.0, -1.0), vec2(1.0, 1.0), vec2(-1.0, -1.0),
                                vec2(1.0, 1.0), vec2(-1.0, 1.0));

void main()
{
    vec2 place = corner + tile_to_clip.z * outwards[gl_VertexID % 6];
    gl_Position = vec4(place * tile_to_clip.xy - 1.0, 0.0, 1.0);
}
