// Squares of grids drawn as triangles. Needs layout.glsl, patch.glsl, project.glsl.
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

// The record of a drawn square (stp_gpu_square).
struct stp_square {
    vec4 lattice;     // of its patch: origin relative to the eye, step
    uvec2 mask;       // bit i % 32 of word i / 32: sample i in Morton order is there
    uint first;       // of level 0, in the Object Texture
    uint patch_index;
};

stp_square stp_square_fetch(uint listed)
{
    int base = int(listed) * STP_SQUARE_TEXELS;
    uvec4 m = texelFetch(square_texture, base + 1);
    return stp_square(uintBitsToFloat(texelFetch(square_texture, base)), m.xy, m.z, m.w);
}

// The vector with this component along an axis (0 x, 1 y, 2 z), and these along the two that follow.
vec3 stp_square_vector(uint axis, float along, vec2 across)
{
    return axis == 0u ? vec3(along, across) : axis == 1u ? vec3(across.y, along, across.x) : vec3(across, along);
}

// Where a square's grid goes: from a sample to the next column, to the next row, and up; world axes.
struct stp_square_axes {
    vec3 column, row, up;
};

stp_square_axes stp_square_axes_fetch(uint listed)
{
    int base = int(listed) * STP_SQUARE_TEXELS;
    vec4 sides = uintBitsToFloat(texelFetch(square_texture, base + 2));
    uvec4 up = texelFetch(square_texture, base + 3);
    return stp_square_axes(stp_square_vector(up.z, 0.0, sides.xy), stp_square_vector(up.z, 0.0, sides.zw),
                           stp_square_vector(up.z, 1.0, uintBitsToFloat(up.xy)));
}

// By how many columns and rows places of an elevation map differ, for a difference in eye space: the dot
// products with the two columns of this matrix. Both are differences along the map's axis of heights.
mat2x3 stp_square_grid_fetch(uint listed)
{
    int base = int(listed) * STP_SQUARE_TEXELS;
    return mat2x3(uintBitsToFloat(texelFetch(square_texture, base + 6).xyz),
                  uintBitsToFloat(texelFetch(square_texture, base + 7).xyz));
}

uint stp_square_flags(uint listed)
{
    return texelFetch(square_texture, int(listed) * STP_SQUARE_TEXELS + 3).w;
}

// The place of a column and a row in Morton order.
uint stp_square_place(uvec2 at)
{
    uvec2 spread = at & 1u | (at & 2u) << 1 | (at & 4u) << 2;
    return spread.x | spread.y << 1;
}

// Column and row of a place in Morton order.
ivec2 stp_square_at(uint place)
{
    ivec2 at = ivec2(place, place >> 1);
    return at & 1 | at >> 1 & 2 | at >> 2 & 4;
}

bool stp_square_has(uvec2 mask, uint place)
{
    return (mask[place >> 5] >> (place & 31u) & 1u) != 0u;
}

// How many samples of a square come before a place.
uint stp_square_rank(uvec2 mask, uint place)
{
    uint low = place < 32u ? (1u << place) - 1u : 0xffffffffu;
    uint high = place < 32u ? 0u : (1u << place - 32u) - 1u;
    return uint(bitCount(mask.x & low) + bitCount(mask.y & high));
}

// The square at this side of a square, -1, 0 or 1 by columns and by rows, but not both 0; STP_NO_SAMPLE:
// none is drawn.
uint stp_square_beside(uint listed, ivec2 side)
{
    int which = 3 * side.y + side.x + 4; // without 4, the square itself
    int word = which > 4 ? which - 1 : which;
    return texelFetch(square_texture, int(listed) * STP_SQUARE_TEXELS + 4 + (word >> 2))[word & 3];
}

// Whether a whole cell is among the last `count`, by columns or by rows, before a side at which no square is
// drawn: a map goes on there with coarser samples, or in another chunk. first: of the cell.
bool stp_square_ends(uint listed, ivec2 first, ivec2 count)
{
    int base = int(listed) * STP_SQUARE_TEXELS + 4;
    uvec4 before = texelFetch(square_texture, base), after = texelFetch(square_texture, base + 1);
    return first.x < count.x && before.w == STP_NO_SAMPLE || first.y < count.y && before.y == STP_NO_SAMPLE ||
           first.x + count.x > 6 && after.x == STP_NO_SAMPLE || first.y + count.y > 6 && after.z == STP_NO_SAMPLE;
}

// Whether a map has a sample at a column and row of a square, both from -1 to 8.
bool stp_square_there(uint listed, ivec2 at)
{
    uint beside = at >> 3 == ivec2(0) ? listed : stp_square_beside(listed, at >> 3);
    int base = int(beside == STP_NO_SAMPLE ? listed : beside) * STP_SQUARE_TEXELS;
    return beside != STP_NO_SAMPLE && stp_square_has(texelFetch(square_texture, base + 1).xy, stp_square_place(uvec2(at & 7)));
}

// A sample of a grid.
struct stp_square_sample {
    bool there;
    uvec4 texel;
    vec4 lattice; // of its patch
    vec3 place;   // relative to the eye, world axes
};

// The sample at a column and row of a square, both from -1 to 8: it may be in the square beside.
stp_square_sample stp_square_sample_at(uint listed, ivec2 at)
{
    uint beside = listed;
    if (at >> 3 != ivec2(0))
        beside = stp_square_beside(listed, at >> 3);
    stp_square s = stp_square_fetch(beside == STP_NO_SAMPLE ? listed : beside);
    uint place = stp_square_place(uvec2(at & 7));
    stp_square_sample c;
    c.there = beside != STP_NO_SAMPLE && stp_square_has(s.mask, place);
    c.texel = texelFetch(object_texture, int(s.first + (c.there ? stp_square_rank(s.mask, place) : 0u)));
    c.there = c.there && !stp_sample_left_out(c.texel);
    c.lattice = s.lattice;
    c.place = stp_sample_position(c.texel, s.lattice.xyz, s.lattice.w);
    return c;
}

// How far up the tangent plane of a sample goes along a side of a cell. Not steeper than 4 to 1, which
// noise may tell.
vec3 stp_square_rise(stp_square_sample c, vec3 side, vec3 up)
{
    vec3 normal = stp_normal_direction(c.texel.z);
    float flat_part = dot(normal, up), limit = 4.0 * length(side) / length(up);
    bool known = (c.texel.y & 0x02000000u) != 0u && flat_part != 0.0;
    return side + up * (known ? clamp(-dot(normal, side) / flat_part, -limit, limit) : 0.0);
}

// The samples of a cell: of a column and a row, of the next column, of the next row, and of both.
struct stp_square_cell {
    stp_square_sample samples[4];
};

// first: column and row of a square, -1 to 7.
stp_square_cell stp_square_cell_fetch(uint listed, ivec2 first)
{
    stp_square_cell c;
    for (int i = 0; i < 4; i++)
        c.samples[i] = stp_square_sample_at(listed, first + ivec2(i & 1, i >> 1));
    return c;
}

// What the surface does in a cell.
struct stp_square_surface {
    // By sample: half a side of the cell, along its columns and along its rows, on the tangent plane.
    vec3 by_column[4], by_row[4];
    // Along which sides of the cell the surface goes: between samples 0 and 1, 2 and 3, 0 and 2, 1 and 3.
    bvec4 sides;
};

// Whether the surface goes on from a sample to the next: their distance is at most twice what either
// tangent plane tells. Else there is a cliff. Maps have none: there is no sample beyond a cliff.
bool stp_square_joins(stp_square_sample a, stp_square_sample b, vec3 half_a, vec3 half_b, bool of_map)
{
    vec3 way = b.place - a.place;
    return a.there && b.there && (of_map || dot(way, way) <= 16.0 * max(dot(half_a, half_a), dot(half_b, half_b)));
}

stp_square_surface stp_square_surface_find(stp_square_cell c, stp_square_axes axes, bool of_map)
{
    stp_square_surface s;
    for (int i = 0; i < 4; i++) {
        s.by_column[i] = 0.5 * stp_square_rise(c.samples[i], axes.column, axes.up);
        s.by_row[i] = 0.5 * stp_square_rise(c.samples[i], axes.row, axes.up);
    }
    s.sides = bvec4(stp_square_joins(c.samples[0], c.samples[1], s.by_column[0], s.by_column[1], of_map),
                    stp_square_joins(c.samples[2], c.samples[3], s.by_column[2], s.by_column[3], of_map),
                    stp_square_joins(c.samples[0], c.samples[2], s.by_row[0], s.by_row[2], of_map),
                    stp_square_joins(c.samples[1], c.samples[3], s.by_row[1], s.by_row[3], of_map));
    return s;
}

// The corners of a cell's quarter, from its sample `own` on: the next along columns, along rows, and
// across.
vec3[4] stp_square_quarter(stp_square_cell c, stp_square_surface s, int own)
{
    int by_column = own ^ 1, by_row = own ^ 2, across = own ^ 3;
    bool column = s.sides[own >> 1], row = s.sides[2 + (own & 1)];
    bool far_column = s.sides[1 - (own >> 1)], far_row = s.sides[3 - (own & 1)];
    // Which samples the surface joins to the own one within the cell.
    bool joined[4];
    joined[own] = true;
    joined[by_column] = column || row && far_row && far_column;
    joined[by_row] = row || column && far_row && far_column;
    joined[across] = column && far_row || row && far_column;
    vec3 place = c.samples[own].place, middle = vec3(0.0);
    float count = 0.0;
    for (int i = 0; i < 4; i++) {
        vec3 at = c.samples[i].place + ((i & 1) != 0 ? -s.by_column[i] : s.by_column[i]) +
                  ((i & 2) != 0 ? -s.by_row[i] : s.by_row[i]);
        middle += joined[i] ? at : vec3(0.0);
        count += joined[i] ? 1.0 : 0.0;
    }
    vec3 half_column = (own & 1) != 0 ? -s.by_column[own] : s.by_column[own];
    vec3 half_row = (own & 2) != 0 ? -s.by_row[own] : s.by_row[own];
    return vec3[](place, column ? 0.5 * (place + c.samples[by_column].place) : place + half_column,
                  row ? 0.5 * (place + c.samples[by_row].place) : place + half_row, middle / count);
}
