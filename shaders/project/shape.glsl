// The disc where a pixel sees a segment, a triangle (MKC08, section 4), or the cell of a grid's
// sample. Needs layout.glsl, patch.glsl, project.glsl, square.glsl, pixel.glsl, ellipse.glsl.

stp_disc stp_vertex_fetch(stp_packing packing, uint number, vec4 lattice)
{
    return stp_disc_decode(stp_sample_words(packing, number), lattice.xyz, lattice.w);
}

vec2 stp_window_of(vec3 position)
{
    return centre.xy + position.xy * stp_pixels_per_unit(-position.z);
}

// Mixes two vertices, a share t of the second. Values without a mean come from the nearer one.
// Two-sided.
stp_disc stp_disc_mix(stp_disc a, stp_disc b, float t)
{
    stp_disc c = a;
    if (t > 0.5) {
        c.class_id = b.class_id;
        c.outlier = b.outlier;
        c.fit = b.fit;
    }
    c.oriented = false;
    c.back_hidden = false;
    c.has_normal = a.has_normal && b.has_normal;
    bool turned = dot(a.normal, b.normal) < 0.0;
    c.normal = normalize(mix(a.normal, turned ? -b.normal : b.normal, t));
    c.position = mix(a.position, b.position, t);
    c.radius = mix(a.radius, b.radius, t);
    c.colour = mix(a.colour, b.colour, t);
    c.intensity = mix(a.intensity, b.intensity, t);
    return c;
}

// If two depths enclose the near plane, the share of the way from the first to the plane; else
// `beyond`.
float stp_near_part(float depth, float other, float beyond)
{
    return depth < viewport.w ? (viewport.w - depth) / max(other - depth, 1e-30) : beyond;
}

// The part of a segment in front of the near plane: its begin and end, as shares of the segment.
vec2 stp_segment_part(stp_disc a, stp_disc b)
{
    return vec2(stp_near_part(-a.position.z, -b.position.z, 0.0),
                1.0 - stp_near_part(-b.position.z, -a.position.z, 0.0));
}

// The point nearest to a window position on the segment from a vertex to the next, as a disc.
stp_disc stp_segment_disc(stp_disc a, stp_disc b, vec2 window)
{
    vec2 part = stp_segment_part(a, b);
    vec3 p = mix(a.position, b.position, part.x), q = mix(a.position, b.position, part.y);
    vec2 from = stp_window_of(p), way = stp_window_of(q) - from;
    float s = clamp(dot(window - from, way) / max(dot(way, way), 1e-30), 0.0, 1.0);
    // s is the share of the segment's image, t that of the segment.
    float t = STP_ORTHOGRAPHIC != 0 ? s : s * p.z / mix(q.z, p.z, s);
    return stp_disc_mix(a, b, mix(part.x, part.y, t));
}

// Where a ray meets a triangle's plane: the barycentric shares of the second and third corner.
vec2 stp_triangle_meet(vec3 a, vec3 b, vec3 c, vec2 window)
{
    vec2 aside = (window - centre.xy) / viewport.z;
    vec3 origin = STP_ORTHOGRAPHIC != 0 ? vec3(aside, 0.0) : vec3(0.0);
    vec3 ray = STP_ORTHOGRAPHIC != 0 ? vec3(0.0, 0.0, -1.0) : vec3(aside, -1.0);
    vec3 side = cross(ray, c - a), turned = cross(origin - a, b - a);
    float volume = dot(b - a, side);
    vec2 parts = vec2(dot(origin - a, side), dot(ray, turned)) / volume;
    return volume == 0.0 ? vec2(0.0) : parts;
}

// Clamps the shares to the triangle: rounding in the rasteriser may let the ray miss the triangle.
vec2 stp_triangle_hold(vec2 parts)
{
    parts = max(parts, 0.0);
    return parts / max(1.0, parts.x + parts.y);
}

// The triangle of a corner and the next two, seen at a window position, as a disc.
stp_disc stp_triangle_disc(stp_packing packing, uint number, vec4 lattice, vec2 window)
{
    stp_disc a = stp_vertex_fetch(packing, number, lattice), b = stp_vertex_fetch(packing, number + 1u, lattice);
    stp_disc c = stp_vertex_fetch(packing, number + 2u, lattice);
    vec2 parts = stp_triangle_hold(stp_triangle_meet(a.position, b.position, c.position, window));
    float sum = parts.x + parts.y;
    return stp_disc_mix(a, stp_disc_mix(b, c, parts.y / max(sum, 1e-30)), sum);
}

// A segment of a ribbon as a flat piece. a_half, b_half: from the line to the edge at each vertex.
struct stp_ribbon {
    stp_disc a, b;
    vec3 a_half, b_half;
};

// The half-width of a ribbon at a vertex: at right angles to the normal and to the way from the
// vertex before to the vertex after.
vec3 stp_ribbon_half(stp_disc v, vec3 before, vec3 after)
{
    vec3 side = cross(v.normal, after - before);
    float square = dot(side, side);
    return square > 0.0 ? side * (v.radius * inversesqrt(square)) : vec3(0.0);
}

vec3 stp_vertex_place(stp_packing packing, uint number, vec4 lattice)
{
    return stp_to_eye(stp_sample_position(stp_sample_words(packing, number), lattice.xyz, lattice.w));
}

// The flat piece between the vertex of a number (a) and the next (b). The level's vertices are ends.x up to
// before ends.y.
stp_ribbon stp_ribbon_between(stp_disc a, stp_disc b, stp_packing packing, uint number, uvec2 ends, vec4 lattice)
{
    stp_ribbon r;
    r.a = a;
    r.b = b;
    vec3 before = number > ends.x ? stp_vertex_place(packing, number - 1u, lattice) : r.a.position;
    vec3 after = number + 2u < ends.y ? stp_vertex_place(packing, number + 2u, lattice) : r.b.position;
    r.a_half = stp_ribbon_half(r.a, before, r.b.position);
    r.b_half = stp_ribbon_half(r.b, r.a.position, after);
    r.b_half = dot(r.a_half, r.b_half) < 0.0 ? -r.b_half : r.b_half;
    return r;
}

// Whether a segment is drawn as a flat piece: it belongs to a ribbon and is wider than a pixel.
bool stp_ribbon_wide(stp_disc a, stp_disc b)
{
    float width = max(a.radius * stp_pixels_per_unit(max(-a.position.z, viewport.w)),
                      b.radius * stp_pixels_per_unit(max(-b.position.z, viewport.w)));
    return a.kind == uint(STP_KIND_RIBBON) && a.has_normal && b.has_normal && width > STP_ELLIPSE_FLOOR_LINE;
}

// The flat piece, seen at a window position, as a disc. Its two triangles share the edge from
// a + a_half to b - b_half.
stp_disc stp_ribbon_disc(stp_ribbon r, vec2 window)
{
    vec3 near_low = r.a.position - r.a_half, near_high = r.a.position + r.a_half;
    vec3 far_low = r.b.position - r.b_half, far_high = r.b.position + r.b_half;
    vec2 parts = stp_triangle_meet(near_low, near_high, far_low, window);
    bool first = min(parts.x, parts.y) >= 0.0 && parts.x + parts.y <= 1.0;
    if (!first)
        parts = stp_triangle_meet(far_high, far_low, near_high, window);
    parts = stp_triangle_hold(parts);
    vec3 at = first ? near_low + parts.x * (near_high - near_low) + parts.y * (far_low - near_low)
                    : far_high + parts.x * (far_low - far_high) + parts.y * (near_high - far_high);
    stp_disc c = stp_disc_mix(r.a, r.b, first ? parts.y : 1.0 - parts.y);
    c.position = at;
    c.radius = 0.0;
    return c;
}

// The mean normal of a triangle's corners. If it faces away from the eye, but the triangle does not, as
// near outlines, it is mirrored.
vec3 stp_square_normal(vec3 mean, vec3 triangle, vec3 place)
{
    vec3 ray = stp_ray_through(place);
    float away = dot(mean, ray), side = dot(triangle, mean) < 0.0 ? -1.0 : 1.0;
    return away > 0.0 && side * dot(triangle, ray) < 0.0 ? mean - 2.0 * away * ray : mean;
}

// Where a pixel sees the plane of a disc, no farther from the disc's centre than its radius.
vec3 stp_disc_meet(stp_disc disc, vec2 window)
{
    float depth = -disc.position.z;
    vec3 place = stp_window_place(window, depth);
    vec3 way = STP_ORTHOGRAPHIC != 0 ? vec3(0.0, 0.0, -1.0) : place / depth;
    float cosine = dot(disc.normal, way);
    float farther = dot(disc.normal, disc.position - place) / (cosine == 0.0 ? 1e-30 : cosine);
    return stp_window_place(window, depth + clamp(farther, -disc.radius, disc.radius));
}

// The disc of a cell's sample, with the mean colour, intensity and normal of all four.
stp_disc stp_square_mean(stp_square_cell cell, vec4 weights, int own)
{
    // A software driver would keep an array in memory that is read at a number known late.
    stp_square_sample s = own == 0 ? cell.samples[0] : own == 1 ? cell.samples[1] : own == 2 ? cell.samples[2] : cell.samples[3];
    stp_disc disc = stp_disc_decode(s.texel, s.lattice.xyz, s.lattice.w);
    vec3 normal = vec3(0.0), colour = vec3(0.0);
    float intensity = 0.0;
    for (int i = 0; i < 4; i++) {
        uvec4 texel = cell.samples[i].texel;
        normal += weights[i] * stp_normal_direction(texel.z);
        colour += weights[i] * unpackUnorm4x8(texel.w).rgb;
        intensity += weights[i] * float(texel.w >> 24);
    }
    disc.colour = colour;
    disc.intensity = intensity / 255.0;
    disc.normal = stp_normal_to_eye(normal);
    return disc;
}

// A seam between maps is narrower than so many pixels, or quarters close it.
#define STP_SEAM_PX 2.0

// Over how many cells, by columns and by rows, pixels of whole cells grow beside a side where no square is
// drawn: over a pixel's diagonal, so that no two pixels beside each other lie on both sides of them. a: the
// cell's corner; b, c: the next along its columns and along its rows.
ivec2 stp_square_seam(vec3 a, vec3 b, vec3 c)
{
    vec2 corner = stp_window_of(a), column = stp_window_of(b) - corner, row = stp_window_of(c) - corner;
    float area = abs(column.x * row.y - column.y * row.x);
    vec2 width = area / max(vec2(length(row), length(column)), 1e-30);
    return ivec2(clamp(ceil(1.42 / max(width, 1e-30)), 1.0, 7.0));
}

// A triangle of a grid's cell, seen at a window position, as a disc. Between the cell's samples, values
// change as places do: bilinear. A quarter has those of its sample. The disc grows nowhere, but at the
// borders of elevation maps.
stp_disc stp_square_disc(uint name, vec2 window)
{
    uint listed = (name & STP_NAME_SAMPLE) >> STP_NAME_SQUARE_SHIFT;
    bool is_whole = (name & STP_SQUARE_WHOLE) != 0u, second = (name & STP_SQUARE_SECOND) != 0u;
    ivec2 at = stp_square_at(name >> STP_NAME_PLACE_SHIFT & 63u);
    stp_square_cell cell = stp_square_cell_fetch(listed, at);
    vec3 a = stp_to_eye(second ? cell.samples[3].place : cell.samples[0].place);
    vec3 b = stp_to_eye(second ? cell.samples[2].place : cell.samples[1].place);
    vec3 c = stp_to_eye(second ? cell.samples[1].place : cell.samples[2].place);
    vec2 parts = stp_triangle_hold(stp_triangle_meet(a, b, c, window));
    vec2 share = is_whole ? (second ? 1.0 - parts : parts) : vec2(0.0), nearer = step(0.5, share);
    vec4 weights = vec4(1.0 - share.x, share.x, 1.0 - share.x, share.x) * vec2(1.0 - share.y, share.y).xxyy;
    stp_disc disc = stp_square_mean(cell, weights, int(nearer.x) + 2 * int(nearer.y));
    disc.position = is_whole ? a + parts.x * (b - a) + parts.y * (c - a) : stp_disc_meet(disc, window);
    disc.normal = stp_square_normal(disc.normal, is_whole ? cross(b - a, c - a) : disc.normal, disc.position);
    bool grows = (stp_square_flags(listed) & STP_SQUARE_OVERLAPS) != 0u &&
                 (!is_whole || stp_square_ends(listed, at, stp_square_seam(a, b, c)));
    disc.radius = grows ? min(disc.radius, STP_SEAM_PX / stp_pixels_per_unit(-disc.position.z)) : 0.0;
    return disc;
}
