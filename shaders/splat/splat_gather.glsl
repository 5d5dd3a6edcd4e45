// Splatting, second step: a pixel visits all splats in its bins. Needs layout.glsl, project.glsl,
// ellipse.glsl, splat_bins.glsl. The including pass defines stp_splat_take, which takes one splat.

layout(binding = 9) uniform usamplerBuffer bin_texture; // where the lists of bins end
layout(binding = 10) uniform samplerBuffer list_texture;
layout(binding = 11) uniform usamplerBuffer look_texture;

layout(location = 1) uniform uint levels_used;

// What a pixel has collected from the splats that cover it.
struct stp_splat_pixel {
    vec2 window;
    vec2 ray;      // (x, y, -1), through the pixel's centre
    float slant;   // length of the ray
    float end;     // least end of the splats' intervals
    float front_q;
    uint front;    // the splat whose interval ends there; of equals the one of least q
    vec4 normal;   // sum; w: sum of the weights
    vec4 colour;   // sum; w: sum of the distances of splats before the end
};

// A splat as a pixel sees it.
struct stp_splat_seen {
    float q, depth, extent;
    vec3 normal;
    vec3 offset; // from the disc's centre to where the pixel's ray meets its plane, eye space
    uint splat;
    bool covers;
};

void stp_splat_take(inout stp_splat_pixel p, stp_splat_seen s);

// Where the pixel's ray meets a disc (as ellipse.glsl, but without normalising the ray).
stp_splat_seen stp_splat_see(stp_splat_pixel p, int at)
{
    vec4 place = texelFetch(list_texture, 2 * at);
    vec4 plane = texelFetch(list_texture, 2 * at + 1);
    vec3 normal = vec3(plane.xy, sqrt(max(1.0 - dot(plane.xy, plane.xy), 0.0)));
    normal.z = plane.z < 0.0 ? -normal.z : normal.z;
    vec2 delta = (p.window - place.xy) * place.z;
    float k = dot(normal.xy, p.ray) - normal.z;
    float least = min(1.0, STP_ELLIPSE_FLOOR * place.z) * p.slant;
    float magnitude = max(abs(k), least);
    float along = dot(delta, normal.xy) / (k > 0.0 ? magnitude : -magnitude);
    vec2 across = delta - p.ray * along;
    float radius = (STP_ORTHOGRAPHIC != 0 ? 1.0 : place.w) / (place.z * viewport.z);
    float q = dot(across, across) + along * along, depth = place.w - radius * along;
    return stp_splat_seen(q, depth, abs(plane.z), normal, radius * vec3(across, along), floatBitsToUint(plane.w),
                          q <= 1.0 && depth > viewport.w);
}

stp_splat_pixel stp_splat_begin(ivec2 here, float end)
{
    vec2 window = vec2(here) + 0.5;
    vec2 ray = STP_ORTHOGRAPHIC != 0 ? vec2(0.0) : (window - centre.xy) / viewport.z;
    return stp_splat_pixel(window, ray, sqrt(dot(ray, ray) + 1.0), end, 0.0, STP_NO_SAMPLE, vec4(0.0), vec4(0.0));
}

void stp_splat_walk(inout stp_splat_pixel p, ivec2 here)
{
    int begin = STP_BIN_HEAD - 1; // a bin begins where the bin before it ends
    for (int level = 0; levels_used >> level != 0u; level++) {
        ivec2 grid = stp_bin_grid(level), at = here >> STP_BIN_BITS + level;
        int bin = begin + at.y * grid.x + at.x;
        bool used = (levels_used >> level & 1u) != 0u;
        int end = used ? int(texelFetch(bin_texture, bin + 1).x) : 0;
        for (int i = int(texelFetch(bin_texture, bin).x); i < end; i++)
            stp_splat_take(p, stp_splat_see(p, i));
        begin += grid.x * grid.y;
    }
}
