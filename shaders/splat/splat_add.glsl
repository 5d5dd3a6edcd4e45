// Splatting: adds up the splats of the front surface, weighted by their Gaussians. Needs splat_gather.glsl.

// Terms are rounded to 1 / STP_SPLAT_STEPS. So sums up to 256 are exact, and the same in any order.
#define STP_SPLAT_STEPS 65536.0

vec3 stp_splat_colour(uint code)
{
    const vec3 most = vec3(2047.0, 2047.0, 1023.0);
    return vec3(uvec3(code, code >> 11, code >> 22) & uvec3(most)) * (1.0 / most);
}

void stp_splat_take(inout stp_splat_pixel p, stp_splat_seen s)
{
    bool counts = s.covers && s.depth <= p.end;
    float weight = counts ? STP_SPLAT_STEPS * exp(-2.0 * s.q) : 0.0;
    // Without `counts` there may be no end, and the product would not be a number.
    float before = counts ? (p.end - s.depth) * stp_pixels_per_unit(p.end) : 0.0;
    uint look = texelFetch(look_texture, int(s.splat)).x;
    p.normal += roundEven(weight * vec4(s.normal, 1.0));
    p.colour += roundEven(weight * vec4(stp_splat_colour(look), before));
}
