// A splat at a pixel. Needs layout.glsl, project.glsl, ellipse.glsl.

flat in vec4 splat_place;
flat in vec4 splat_plane;
flat in uvec3 splat_look;

vec3 stp_splat_colour()
{
    return vec3(uvec3(splat_look.y, splat_look.y >> 11, splat_look.y >> 22) & uvec3(2047u, 2047u, 1023u)) /
           vec3(2047.0, 2047.0, 1023.0);
}

// Where the ray v = (x, y, -1) through the pixel's centre meets the disc: the ellipse's q and the depth there
// (ellipse.glsl, without its normalised ray).
vec2 stp_splat_meet()
{
    vec2 delta = (gl_FragCoord.xy - splat_place.xy) * splat_place.z;
    vec2 v = STP_ORTHOGRAPHIC != 0 ? vec2(0.0) : (gl_FragCoord.xy - centre.xy) / viewport.z;
    float k = dot(splat_plane.xy, v) - splat_plane.z;
    float least = min(1.0, STP_ELLIPSE_FLOOR * splat_place.z) * sqrt(dot(v, v) + 1.0);
    float magnitude = max(abs(k), least);
    float along = dot(delta, splat_plane.xy) / (k > 0.0 ? magnitude : -magnitude);
    vec2 s = delta - v * along;
    return vec2(dot(s, s) + along * along, splat_place.w - uintBitsToFloat(splat_look.x) * along);
}
