// Where a pixel sees a segment or a triangle: a disc there (CG08, section 4). Needs layout.glsl, patch.glsl,
// project.glsl.

stp_disc stp_vertex_fetch(uint index, vec4 lattice)
{
    return stp_disc_decode(texelFetch(object_texture, int(index)), lattice.xyz, lattice.w);
}

vec2 stp_window_of(vec3 position)
{
    return centre.xy + position.xy * stp_pixels_per_unit(-position.z);
}

// The mean of two vertices, t of it the second; of what has no mean, the nearer one's. Seen from both sides.
stp_disc stp_disc_mix(stp_disc a, stp_disc b, float t)
{
    stp_disc c = a;
    if (t > 0.5) {
        c.class_id = b.class_id;
        c.outlier = b.outlier;
    }
    c.oriented = false;
    c.has_normal = a.has_normal && b.has_normal;
    bool turned = dot(a.normal, b.normal) < 0.0;
    c.normal = normalize(mix(a.normal, turned ? -b.normal : b.normal, t));
    c.position = mix(a.position, b.position, t);
    c.radius = mix(a.radius, b.radius, t);
    c.colour = mix(a.colour, b.colour, t);
    c.intensity = mix(a.intensity, b.intensity, t);
    c.elevation = mix(a.elevation, b.elevation, t);
    return c;
}

// Where two depths enclose the near plane, how far from the first it lies, of 1; else `beyond`.
float stp_near_part(float depth, float other, float beyond)
{
    return depth < viewport.w ? (viewport.w - depth) / max(other - depth, 1e-30) : beyond;
}

// Of the segment between two vertices what lies before the near plane: where it begins and ends, of 1.
vec2 stp_segment_part(stp_disc a, stp_disc b)
{
    return vec2(stp_near_part(-a.position.z, -b.position.z, 0.0),
                1.0 - stp_near_part(-b.position.z, -a.position.z, 0.0));
}

// The segment from a vertex to the next, nearest to a window position.
stp_disc stp_segment_disc(uint index, vec4 lattice, vec2 window)
{
    stp_disc a = stp_vertex_fetch(index, lattice), b = stp_vertex_fetch(index + 1u, lattice);
    vec2 part = stp_segment_part(a, b);
    vec3 p = mix(a.position, b.position, part.x), q = mix(a.position, b.position, part.y);
    vec2 from = stp_window_of(p), way = stp_window_of(q) - from;
    float s = clamp(dot(window - from, way) / max(dot(way, way), 1e-30), 0.0, 1.0);
    float t = STP_ORTHOGRAPHIC != 0 ? s : s * p.z / mix(q.z, p.z, s); // along it, not along its image
    return stp_disc_mix(a, b, mix(part.x, part.y, t));
}

// Of a triangle's second and third corner, their parts where a ray meets it; the ray may miss it by the rounding of
// its rasteriser.
vec2 stp_triangle_parts(vec3 a, vec3 b, vec3 c, vec2 window)
{
    vec2 aside = (window - centre.xy) / viewport.z;
    vec3 origin = STP_ORTHOGRAPHIC != 0 ? vec3(aside, 0.0) : vec3(0.0);
    vec3 ray = STP_ORTHOGRAPHIC != 0 ? vec3(0.0, 0.0, -1.0) : vec3(aside, -1.0);
    vec3 side = cross(ray, c - a), turned = cross(origin - a, b - a);
    float volume = dot(b - a, side);
    vec2 parts = vec2(dot(origin - a, side), dot(ray, turned)) / volume;
    parts = volume == 0.0 ? vec2(0.0) : max(parts, 0.0);
    return parts / max(1.0, parts.x + parts.y);
}

// The triangle of a corner and the next two, at a window position.
stp_disc stp_triangle_disc(uint index, vec4 lattice, vec2 window)
{
    stp_disc a = stp_vertex_fetch(index, lattice), b = stp_vertex_fetch(index + 1u, lattice);
    stp_disc c = stp_vertex_fetch(index + 2u, lattice);
    vec2 parts = stp_triangle_parts(a.position, b.position, c.position, window);
    float sum = parts.x + parts.y;
    return stp_disc_mix(a, stp_disc_mix(b, c, parts.y / max(sum, 1e-30)), sum);
}
