// Squares of grids drawn as triangles (pieces.glsl) or splats, and their samples. Needs layout.glsl, patch.glsl,
// project.glsl.

// The record of a drawn square (stp_gpu_square).
struct stp_square {
    vec4 lattice;     // of its patch: origin relative to the eye, step
    uvec2 mask;       // bit i % 32 of word i / 32: sample i in Morton order is there
    uint patch_index;
};

stp_square stp_square_fetch(uint listed)
{
    int base = int(listed) * STP_SQUARE_TEXELS;
    uvec4 m = texelFetch(square_texture, base + 1);
    return stp_square(uintBitsToFloat(texelFetch(square_texture, base)), m.xy, m.z);
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

// A drawn square, or what takes its place where none is.
struct stp_square_read {
    bool drawn;
    stp_square square;
    stp_packing packing; // of its patch
};

// The square at this side of a square, or itself: -1, 0 or 1 by columns and by rows.
stp_square_read stp_square_read_beside(uint listed, ivec2 side)
{
    uint beside = side == ivec2(0) ? listed : stp_square_beside(listed, side);
    bool drawn = beside != STP_NO_SAMPLE;
    uint read = drawn ? beside : listed;
    stp_square square = stp_square_fetch(read);
    return stp_square_read(drawn, square, stp_packing_fetch(square.patch_index));
}

// The sample at a column and row, modulo 8.
stp_square_sample stp_square_sample_in(stp_square_read of, ivec2 at)
{
    uint place = stp_square_place(uvec2(at & 7));
    stp_square_sample c;
    c.there = of.drawn && stp_square_has(of.square.mask, place);
    c.texel = stp_sample_words(of.packing, of.packing.finer.x + (c.there ? stp_square_rank(of.square.mask, place) : 0u));
    c.there = c.there && !stp_sample_left_out(c.texel);
    c.lattice = of.square.lattice;
    c.place = stp_sample_position(c.texel, c.lattice.xyz, c.lattice.w);
    return c;
}

// The sample at a column and row of a square, both from -1 to 8: it may be in the square beside.
stp_square_sample stp_square_sample_at(uint listed, ivec2 at)
{
    return stp_square_sample_in(stp_square_read_beside(listed, at >> 3), at);
}

// The samples of a cell: of a column and a row, of the next column, of the next row, and of both.
struct stp_square_cell {
    stp_square_sample samples[4];
};

// first: column and row of a square, -1 to 7.
stp_square_cell stp_square_cell_fetch(uint listed, ivec2 first)
{
    // No loop: a software driver would keep it, and the array in memory.
    stp_square_cell c;
    c.samples[0] = stp_square_sample_at(listed, first);
    c.samples[1] = stp_square_sample_at(listed, first + ivec2(1, 0));
    c.samples[2] = stp_square_sample_at(listed, first + ivec2(0, 1));
    c.samples[3] = stp_square_sample_at(listed, first + 1);
    return c;
}
