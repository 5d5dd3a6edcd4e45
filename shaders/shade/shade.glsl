// Deferred shading of a finished pixel ("Shading" in README.md). Needs project.glsl, pixel.glsl,
// palette.glsl, height.glsl.

vec3 stp_phong(vec3 colour, vec3 n, vec3 v)
{
    vec3 l = light.xyz;
    float lit = dot(n, l);
    // |l + v|^2 = 2 + 2 l v
    float x = max(0.0, (lit + dot(n, v)) * inversesqrt(max(2.0 + 2.0 * dot(l, v), 1e-12)));
    float x2 = x * x, x4 = x2 * x2, x8 = x4 * x4, x16 = x8 * x8;
    // ceilings and walls beside the view: what the light leaves dark is lit from the eye
    float fill = clip_min.w * max(0.0, dot(n, v)) * (1.0 - max(0.0, lit));
    return colour * (0.18 + 0.74 * max(0.0, lit) + 0.08 * max(0.0, n.z) + fill) +
           0.16 * x16 * x16 * x8;
}

// A tube's normal: the direction across the tangent that is nearest to `towards`.
vec3 stp_tube_normal(vec3 tangent, vec3 towards)
{
    vec3 n = towards - tangent * dot(towards, tangent);
    float norm = dot(n, n);
    return norm > 1e-12 ? n * inversesqrt(norm) : towards;
}

// The direction that tubes' normals turn to: the light; for pictures of normals, the eye.
#if STP_SHADE == STP_SHADE_PHONG || STP_SHADE == STP_SHADE_LAMBERT || STP_OVERLAY
#define STP_SHADE_TOWARDS light.xyz
#else
#define STP_SHADE_TOWARDS v
#endif

// The normal that a pixel is lit with. v: towards the eye.
vec3 stp_shade_normal(stp_pixel p, vec3 v)
{
    vec3 n = stp_tag_two_sided(p.tag) && dot(p.normal, v) < 0.0 ? -p.normal : p.normal;
    return stp_tag_tube(p.tag) ? stp_tube_normal(p.normal, STP_SHADE_TOWARDS) : n;
}

// The colour before light: the pixel's own, or that of its height. With elevation under an overlay
// the pixel's own is the overlay's.
vec3 stp_shade_colour(stp_pixel p, vec3 n, vec2 window)
{
#if STP_COLOUR == STP_COLOUR_ELEVATION && (STP_SHADE < STP_SHADE_LEVEL || STP_OVERLAY)
    float height = stp_height_of(p, n, window).height;
    vec3 c = stp_palette_ramp((height - colour_range.x) * colour_range.y);
#if STP_OVERLAY && STP_SHADE != STP_SHADE_CONFIDENCE
    c = mix(c, p.colour, colour_range.z);
#endif
    return c;
#else
    return p.colour;
#endif
}

// RGBA, alpha 1 where covered. window: the pixel's centre.
vec4 stp_shade(stp_pixel p, vec2 window)
{
    vec3 v = -stp_ray(window);
    vec3 n = stp_shade_normal(p, v);
#if STP_SHADE == STP_SHADE_PHONG
    vec3 c = stp_phong(stp_shade_colour(p, n, window), n, v);
#elif STP_SHADE == STP_SHADE_LAMBERT
    vec3 c = stp_shade_colour(p, n, window) * (0.05 + 0.85 * max(0.0, dot(n, light.xyz)));
#elif STP_SHADE == STP_SHADE_NORMAL
    vec3 c = n * 0.5 + 0.5;
#elif STP_SHADE == STP_SHADE_DEPTH
    vec3 c = vec3(1.0 - (p.z_min - quality.z) / (quality.w - quality.z));
#else
#if STP_SHADE == STP_SHADE_CONFIDENCE
    vec3 c = stp_palette_confidence(stp_tag_source(p.tag));
#if STP_OVERLAY
    c = mix(stp_shade_colour(p, n, window), c, colour_range.z);
#endif
#else
    vec3 c = stp_shade_colour(p, n, window); // unlit; of level, chunk, error: written at projection
#endif
#if STP_OVERLAY
    c = stp_phong(c, n, v);
#endif
#endif
    return p.tag != 0 ? vec4(clamp(c, 0.0, 1.0), 1.0) : vec4(0.0);
}

// The same as it is stored, rounded here: GPUs round what is drawn in other ways than shaders do.
vec4 stp_shade_rounded(stp_pixel p, vec2 window)
{
    return unpackUnorm4x8(packUnorm4x8(stp_shade(p, window)));
}
