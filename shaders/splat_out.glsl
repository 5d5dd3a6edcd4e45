// A sample becomes a splat: a point sprite that holds its ellipse (Botsch et al. 2005, "High-Quality Surface
// Splatting on Today's GPUs"). Needs layout.glsl, patch.glsl, project.glsl, pixel.glsl, ellipse.glsl,
// sample_pixel.glsl.

// With position and size 16 components: a geometry shader may write 1024 in all. Lengths on the disc are in its
// radii.
flat out vec4 splat_place; // window coordinates of the centre; 1 / radius in pixels; depth of the centre
flat out vec4 splat_plane; // normal, eye space; how deep its interval is
flat out uvec3 splat_look; // radius, world units; colour, 11 + 11 + 10 bits; number of the sample

uint stp_splat_colour_pack(vec3 colour)
{
    uvec3 code = uvec3(clamp(colour, 0.0, 1.0) * vec3(2047.0, 2047.0, 1023.0) + 0.5);
    return code.r | code.g << 11 | code.b << 22;
}

// Half the side of a square around a ball in window coordinates, pixels. v: ray through its centre.
float stp_splat_reach(float radius, float depth, vec3 v)
{
    if (STP_ORTHOGRAPHIC != 0)
        return radius * viewport.z;
    return radius * viewport.z * length(v) / max(depth - radius, viewport.w);
}

// Writes a sample, id.x, of a patch, id.y; outside the clip volume if it is not drawn.
void stp_splat_write(uvec2 id)
{
    vec3 offset = stp_chunk_fetch(stp_patch_slot(id.y)).offset;
    vec4 lattice = stp_lattice_fetch(id.y, offset);
    gl_Position = stp_project(texelFetch(object_texture, int(id.x)), lattice.xyz, lattice.w);
    stp_pixel p = stp_sample_pixel(id, vec2(0.0));
    if (gl_Position.z <= 1.0)
        gl_Position.xy = 2.0 * p.d / viewport.xy - 1.0;
    vec3 v = STP_ORTHOGRAPHIC != 0 ? vec3(0.0, 0.0, -1.0) : vec3((p.d - centre.xy) / viewport.z, -1.0);
    float ppu = stp_pixels_per_unit(p.z_min);
    float radius = max(p.radius, STP_ELLIPSE_FLOOR / ppu);
    gl_PointSize = 2.0 * stp_splat_reach(radius, p.z_min, v);
    splat_place = vec4(p.d, 1.0 / (radius * ppu), p.z_min);
    if (p.radius <= 0.0) { // its own pixel
        gl_PointSize = 1.0;
        splat_place.z = 0.0;
    }
    splat_plane = vec4(p.normal, p.z_max - p.z_min);
    splat_look = uvec3(floatBitsToUint(radius), stp_splat_colour_pack(p.colour), id.x);
}
