// The pieces of squares of grids, to be rasterised: cells and quarters. Needs layout.glsl, patch.glsl,
// project.glsl, square.glsl.
//
// Between four samples of a grid lies a cell. If the surface joins all four, a cell is two triangles.
// Else it falls into quarters, one for each sample that is there:
//
//     o------m------x      o: samples        x: a sample that is missing, or beyond a cliff
//     |      |             m: half-way to the next sample, or where the sample's tangent plane
//     m------c------m         is half a cell on
//     |      |      |      c: the mean of what the joined samples say of the cell's middle
//     o------m------o
//
// So a hole keeps its width, and a surface at a cliff goes on by half a cell. At the borders of elevation
// maps others go on: there pixels of quarters have the samples' radii, so pull and push close seams.

#define STP_SQUARE_PIECES 256u // the most of a square: a sample's quarters lie in four cells
#define STP_PIECE_INDICES 6u   // two triangles
#define STP_SQUARE_CELLS 81    // 9 x 9, from column and row -1 on
#define STP_QUARTER_GROUP 64u  // cells with quarters that a group of square_quarters.comp takes

layout(location = 4) uniform uint first_square;

// Four corners a piece: a place relative to the eye, world axes, then the name of the triangle that it
// ends. STP_SQUARE_PIECES pieces a square.
layout(std430, binding = 1) writeonly buffer stp_pieces_block {
    uvec4 corners[];
};

// The cells that have quarters, in any order: the group counts of an indirect dispatch, then how many
// cells there are, and of each the piece that its first quarter is << 7 | the cell's number.
layout(std430, binding = 3) buffer stp_quarters_block {
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

stp_square_corner stp_square_corner_at(uint listed, ivec2 at, stp_square_axes axes)
{
    stp_square_sample c = stp_square_sample_at(listed, at);
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

// piece: of all. at: the column and row that name it. which: STP_SQUARE_WHOLE or 0.
void stp_piece_write(uint piece, vec3 places[4], uint listed, ivec2 at, uint which)
{
    uint name = STP_NAME_SQUARE | listed << STP_NAME_SQUARE_SHIFT | stp_square_place(uvec2(at)) << STP_NAME_PLACE_SHIFT | which;
    for (uint i = 0u; i < 4u; i++) // a triangle has the name of its last corner
        corners[4u * piece + i] = uvec4(floatBitsToUint(places[i]), i < 3u ? name : name | STP_SQUARE_SECOND);
}
