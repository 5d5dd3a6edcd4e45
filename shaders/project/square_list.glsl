// Lists triangles of squares (square.comp, square_quarters.comp). Needs layout.glsl, patch.glsl, project.glsl,
// square.glsl, pieces.glsl.

// Three floats a place, relative to the eye, world axes. STP_SQUARE_PLACES a square.
layout(std430, binding = 1) writeonly buffer stp_places_block {
    float places[];
};

// STP_SQUARE_TRIANGLES a square: the lowest bits of a triangle's name, and from bit STP_NAME_SQUARE_SHIFT on
// the number of its quarter. A square's triangles of cells end before number STP_CELL_TRIANGLES, where those
// of quarters begin.
layout(std430, binding = 2) writeonly buffer stp_triangles_block {
    uint triangles[];
};

// One a square, as GL's DrawArraysIndirectCommand.
struct stp_square_draw {
    uint count, instances, first, base_instance;
};

layout(std430, binding = 3) buffer stp_square_draws_block {
    stp_square_draw draws[];
};

// The cells that have quarters, in any order: the group counts of an indirect dispatch, then how many
// cells there are, and of each its square's number << 7 | its own.
layout(std430, binding = 4) buffer stp_quarters_block {
    uint groups_x, groups_y, groups_z, quartered_count, quartered[];
};

ivec2 stp_cell_first(uint cell)
{
    return ivec2(cell % 9u, cell / 9u) - 1;
}

// A sample as a corner of cells.
struct stp_square_corner {
    bool there;
    vec3 place;
    // Half a side of a cell, along its columns and along its rows, on the sample's tangent plane.
    vec3 by_column, by_row;
};

// How far up the tangent plane of a sample goes along a side of a cell. Not steeper than 4 to 1, which
// noise may tell.
vec3 stp_square_rise(stp_square_sample c, vec3 side, vec3 up)
{
    vec3 normal = stp_normal_direction(c.texel.z);
    float flat_part = dot(normal, up), limit = 4.0 * length(side) / length(up);
    bool known = (c.texel.y & 0x02000000u) != 0u && flat_part != 0.0;
    return side + up * (known ? clamp(-dot(normal, side) / flat_part, -limit, limit) : 0.0);
}

stp_square_corner stp_square_corner_of(stp_square_sample c, stp_square_axes axes)
{
    return stp_square_corner(c.there, c.place, 0.5 * stp_square_rise(c, axes.column, axes.up),
                             0.5 * stp_square_rise(c, axes.row, axes.up));
}

// Whether the surface goes on from a sample to the next, half a side away from each: their distance is
// at most twice what either tangent plane tells. Else there is a cliff. Maps have none: there is no
// sample beyond a cliff.
bool stp_square_joins(stp_square_corner a, stp_square_corner b, vec3 half_a, vec3 half_b, bool of_map)
{
    vec3 way = b.place - a.place;
    return a.there && b.there && (of_map || dot(way, way) <= 16.0 * max(dot(half_a, half_a), dot(half_b, half_b)));
}

// Along which sides of a cell the surface goes: between samples 0 and 1, 2 and 3, 0 and 2, 1 and 3.
bvec4 stp_square_sides(stp_square_corner c[4], bool of_map)
{
    return bvec4(stp_square_joins(c[0], c[1], c[0].by_column, c[1].by_column, of_map),
                 stp_square_joins(c[2], c[3], c[2].by_column, c[3].by_column, of_map),
                 stp_square_joins(c[0], c[2], c[0].by_row, c[2].by_row, of_map),
                 stp_square_joins(c[1], c[3], c[1].by_row, c[3].by_row, of_map));
}

// Which samples of a cell have a quarter that their square draws, if it is not whole.
bvec4 stp_square_quarters(stp_square_corner c[4], ivec2 first)
{
    ivec2 last = first + 1;
    bvec2 low = greaterThanEqual(first, ivec2(0)), high = lessThan(last, ivec2(8));
    return bvec4(c[0].there && low.x && low.y, c[1].there && high.x && low.y, c[2].there && low.x && high.y,
                 c[3].there && high.x && high.y);
}

// Window position of a place relative to the eye, and its depth.
vec3 stp_place_window(vec3 from_eye)
{
    vec3 eye = stp_to_eye(from_eye);
    return vec3(centre.xy + eye.xy * stp_pixels_per_unit(-eye.z), -eye.z);
}

// Rasterisers round corners to 1/16 pixel or finer.
#define STP_CORNER_SLACK 0.032

// Whether a rasteriser may find a pixel's centre in a triangle. Many triangles of a whole model hold none.
// a, b, c: stp_place_window.
bool stp_triangle_seen(vec3 a, vec3 b, vec3 c)
{
    vec3 low = min(a, min(b, c)), high = max(a, max(b, c));
    vec2 first = ceil(max(low.xy - STP_CORNER_SLACK, 0.0) - 0.5);
    vec2 last = floor(min(high.xy + STP_CORNER_SLACK, viewport.xy) - 0.5);
    // If the box holds one centre: on which side of each edge that is, and what rounding may change.
    vec2 p = first + 0.5, ab = b.xy - a.xy, bc = c.xy - b.xy, ca = a.xy - c.xy;
    vec3 side = vec3(ab.x * (p.y - a.y) - ab.y * (p.x - a.x), bc.x * (p.y - b.y) - bc.y * (p.x - b.x),
                     ca.x * (p.y - c.y) - ca.y * (p.x - c.x));
    float slack = 1.42 * STP_CORNER_SLACK * (high.x - low.x + high.y - low.y);
    bool within = all(greaterThanEqual(side, vec3(-slack))) || all(lessThanEqual(side, vec3(slack)));
    bool holds = all(lessThanEqual(first, last)) && (first != last || within);
    return high.z > viewport.w && (low.z <= viewport.w || holds);
}

// Writes a place of a square. square: of the part that is listed.
void stp_place_write(uint square, uint i, vec3 place)
{
    for (uint k = 0u; k < 3u; k++)
        places[3u * (square * STP_SQUARE_PLACES + i) + k] = place[k];
}
