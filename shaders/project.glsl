// A sample becomes a pixel. Needs patch.glsl.

// Unit ray from the eye through an eye-space position.
vec3 stp_ray_through(vec3 position)
{
    return STP_ORTHOGRAPHIC != 0 ? vec3(0.0, 0.0, -1.0) : normalize(position);
}

// Unit ray through window coordinates, pixels.
vec3 stp_ray(vec2 window)
{
    if (STP_ORTHOGRAPHIC != 0)
        return vec3(0.0, 0.0, -1.0);
    return normalize(vec3((window - 0.5 * viewport.xy) / viewport.z, -1.0));
}

// Pixels that a world unit facing the eye covers at a depth.
float stp_pixels_per_unit(float depth)
{
    return STP_ORTHOGRAPHIC != 0 ? viewport.z : viewport.z / depth;
}

// True where a disc of known orientation shows its back.
bool stp_disc_faces_away(stp_disc disc)
{
    return disc.oriented && STP_KEEP_BACK_FACES == 0 && dot(disc.normal, stp_ray_through(disc.position)) >= 0.0;
}

// Clip position of the centre of the pixel that holds a disc's centre, so that no rasteriser's
// rounding moves it; outside the clip volume if the disc is not drawn. Depth runs from 1 at the near
// plane to 0 far away.
vec4 stp_project(stp_disc disc)
{
    const vec4 nowhere = vec4(2.0, 2.0, 2.0, 1.0);
    float depth = -disc.position.z;
    if (depth <= viewport.w || stp_disc_faces_away(disc))
        return nowhere;
    vec2 window = 0.5 * viewport.xy + disc.position.xy * stp_pixels_per_unit(depth);
    vec2 centre = floor(window) + 0.5;
    if (any(lessThan(window, vec2(0.0))) || any(greaterThanEqual(window, viewport.xy)))
        return nowhere;
    float z = STP_ORTHOGRAPHIC != 0 ? 1.0 - depth / (2.0 * quality.w) : viewport.w / depth;
    return vec4(2.0 * centre / viewport.xy - 1.0, z, 1.0);
}
