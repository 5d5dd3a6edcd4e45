// Copies the picture into the host's framebuffer through the host's depth test: only covered
// pixels, each at its depth as the host computes depth.

layout(binding = 4) uniform sampler2D picture;       // RGBA, alpha 1 where covered
layout(binding = 5) uniform sampler2D picture_depth; // along the camera's axis

layout(location = 0) uniform ivec2 corner; // of the host's viewport, pixels
layout(location = 1) uniform bool flipped; // the host's window has its origin at the upper left
// Window depth is x + y / depth (orthographic: x + y * depth); z and w: the host's depth range.
layout(location = 2) uniform vec4 window_depth;
layout(location = 3) uniform bool orthographic;
layout(location = 4) uniform bool clamped;      // nothing is clipped by depth
layout(location = 5) uniform bool linear_light; // the host's colours are not encoded

layout(location = 0) out vec4 colour;

vec3 stp_decode_srgb(vec3 c)
{
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy) - corner;
    if (flipped)
        pixel.y = textureSize(picture, 0).y - 1 - pixel.y;
    vec4 seen = texelFetch(picture, pixel, 0);
    float depth = texelFetch(picture_depth, pixel, 0).x;
    if (seen.a == 0.0)
        discard;
    float z = window_depth.x + window_depth.y * (orthographic ? depth : 1.0 / depth);
    if (!clamped && (z < window_depth.z || z > window_depth.w))
        discard;
    gl_FragDepth = clamp(z, window_depth.z, window_depth.w);
    colour = linear_light ? vec4(stp_decode_srgb(seen.rgb), seen.a) : seen;
}
