// Lists the cells of squares of grids as pieces, to be rasterised: those that begin in the square if
// the surface joins their samples, and where quarters of the others will lie (square_quarters.comp). One
// group of invocations a square, one invocation a cell. A square's pieces have the same order in every
// picture.
#define STP_FRAME_HELD
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "square.glsl"
#include "pieces.glsl"

layout(local_size_x = STP_SQUARE_CELLS) in;

// One a square, as GL's DrawElementsIndirectCommand.
struct stp_pieces_draw {
    uint index_count, instances, first_index, base_vertex, base_instance;
};

layout(std430, binding = 2) writeonly buffer stp_pieces_draws_block {
    stp_pieces_draw draws[];
};

// The samples of the square and those around it, by rows, from column and row -1 on.
#define STP_AROUND 10
shared stp_square_corner around[STP_AROUND * STP_AROUND];

// Which cells are whole, and which have a quarter of their sample 0, 1, 2, 3: bits by cell.
shared uint cells[5][3];

// How many pieces of some kinds come before a cell.
uint stp_pieces_before(uint cell, int first_kind, int end_kind)
{
    uint count = 0u;
    for (uint i = 0u; i < 3u; i++) {
        uint mask = cell >= 32u * (i + 1u) ? 0xffffffffu : cell > 32u * i ? (1u << cell - 32u * i) - 1u : 0u;
        for (int kind = first_kind; kind < end_kind; kind++)
            count += uint(bitCount(cells[kind][i] & mask));
    }
    return count;
}

// Whether a shape lies outside of one side of the picture, or behind the eye.
bool stp_piece_outside(vec3 corners[4])
{
    bvec4 all_outside = bvec4(true);
    for (int i = 0; i < 4; i++) {
        vec4 clip = stp_clip_position(stp_to_eye(corners[i]));
        all_outside = bvec4(all_outside.x && clip.x > clip.w, all_outside.y && clip.x < -clip.w,
                            all_outside.z && clip.y > clip.w, all_outside.w && clip.y < -clip.w);
    }
    return any(all_outside);
}

// Lists a cell for square_quarters.comp.
void stp_quartered_add(uint cell, uint piece)
{
    uint i = atomicAdd(quartered_count, 1u);
    if (i % STP_QUARTER_GROUP == 0u)
        atomicAdd(groups_x, 1u);
    quartered[i] = piece << 7 | cell;
}

void main()
{
    stp_frame_hold();
    uint cell = gl_LocalInvocationIndex, listed = first_square + gl_WorkGroupID.x;
    ivec2 first = stp_cell_first(cell);
    if (cell < 15u)
        cells[cell / 3u][cell % 3u] = 0u;
    stp_square_axes axes = stp_square_axes_fetch(listed);
    for (int i = int(cell); i < STP_AROUND * STP_AROUND; i += STP_SQUARE_CELLS)
        around[i] = stp_square_corner_at(listed, ivec2(i % STP_AROUND, i / STP_AROUND) - 1, axes);
    barrier();

    stp_square_corner c[4];
    for (int i = 0; i < 4; i++)
        c[i] = around[(first.y + 1 + (i >> 1)) * STP_AROUND + first.x + 1 + (i & 1)];
    bool joined = all(stp_square_sides(c, (stp_square_flags(listed) & STP_SQUARE_OF_MAP) != 0u));
    vec3 whole[4] = vec3[](c[0].place, c[1].place, c[2].place, c[3].place);
    bool is_whole = joined && min(first.x, first.y) >= 0 && !stp_piece_outside(whole);
    bvec4 quarters = stp_square_quarters(c, first);
    for (int own = 0; own < 4; own++)
        if (!joined && quarters[own])
            atomicOr(cells[own][cell >> 5], 1u << (cell & 31u));
    if (is_whole)
        atomicOr(cells[4][cell >> 5], 1u << (cell & 31u));
    barrier();

    uint slot = gl_WorkGroupID.x * STP_SQUARE_PIECES;
    uint whole_count = stp_pieces_before(STP_SQUARE_CELLS, 4, 5), before = stp_pieces_before(cell, 0, 4);
    if (is_whole)
        stp_piece_write(slot + stp_pieces_before(cell, 4, 5), whole, listed, first, STP_SQUARE_WHOLE);
    if (!joined && any(quarters))
        stp_quartered_add(cell, slot + whole_count + before);
    if (cell == STP_SQUARE_CELLS - 1u)
        draws[gl_WorkGroupID.x] =
            stp_pieces_draw(STP_PIECE_INDICES * (whole_count + stp_pieces_before(STP_SQUARE_CELLS, 0, 4)), 1u, 0u,
                            4u * slot, 0u);
}
