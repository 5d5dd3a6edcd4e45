// Lists the triangles of squares of grids, to be rasterised: those of the cells that begin in a square if the
// surface joins their samples, and which of the others have quarters (square_quarters.comp). One invocation a
// square, which goes through its cells row by row: so samples are not shared through memory, which costs a
// software driver more than to fetch them twice, and a square's triangles have the same order in every picture.
#define STP_FRAME_HELD
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "square.glsl"
#include "pieces.glsl"
#include "square_list.glsl"

layout(local_size_x = 8) in;

// Two samples of a column: of a row, and of the next.
struct stp_square_pair {
    stp_square_corner corners[2];
    vec3 windows[2];
};

stp_square_pair stp_square_pair_of(stp_square_read low, stp_square_read high, ivec2 at, stp_square_axes axes)
{
    stp_square_pair p;
    p.corners[0] = stp_square_corner_of(stp_square_sample_in(low, at), axes);
    p.corners[1] = stp_square_corner_of(stp_square_sample_in(high, at + ivec2(0, 1)), axes);
    for (int i = 0; i < 2; i++)
        p.windows[i] = stp_place_window(p.corners[i].place);
    return p;
}

// Lists cells for square_quarters.comp. cells: their bits.
void stp_quartered_add(uint square, uvec4 cells)
{
    ivec4 counts = bitCount(cells);
    uint count = uint(counts.x + counts.y + counts.z);
    uint at = atomicAdd(quartered_count, count);
    atomicMax(groups_x, (at + count + STP_QUARTER_GROUP - 1u) / STP_QUARTER_GROUP);
    for (uint end = at + count; at < end; at++)
        quartered[at] = square << 7 | uint(stp_set_take(cells));
}

void main()
{
    stp_frame_hold();
    uint square = gl_GlobalInvocationID.x, listed = squares.x + square;
    if (square >= squares.y)
        return;
    stp_square_axes axes = stp_square_axes_fetch(listed);
    bool of_map = (stp_square_flags(listed) & STP_SQUARE_OF_MAP) != 0u;
    uint end = square * STP_SQUARE_TRIANGLES + STP_CELL_TRIANGLES, next = end; // listed backwards from there
    uvec4 quartered_cells = uvec4(0u);
    for (int row = -1; row < 8; row++) {
        stp_square_pair before; // no cell ends in the first column, where it is not set
        for (int side = -1; side < 2; side++) {
            stp_square_read low = stp_square_read_beside(listed, ivec2(side, row >> 3));
            stp_square_read high = stp_square_read_beside(listed, ivec2(side, row + 1 >> 3));
            int last = side < 0 ? -1 : side == 0 ? 7 : 8;
            for (int column = max(8 * side, -1); column <= last; column++) {
                stp_square_pair now = stp_square_pair_of(low, high, ivec2(column, row), axes);
                ivec2 first = ivec2(column - 1, row);
                stp_square_corner c[4] =
                    stp_square_corner[](before.corners[0], now.corners[0], before.corners[1], now.corners[1]);
                bool joined = all(stp_square_sides(c, of_map)), whole = joined && min(first.x, first.y) >= 0;
                uint name = stp_square_place(uvec2(first)) << STP_NAME_PLACE_SHIFT | STP_SQUARE_WHOLE;
                if (column >= 0)
                    stp_place_write(square, uint(9 * (row + 1) + column), c[3].place);
                if (whole && stp_triangle_seen(before.windows[0], now.windows[0], before.windows[1]))
                    triangles[--next] = name;
                if (whole && stp_triangle_seen(before.windows[1], now.windows[0], now.windows[1]))
                    triangles[--next] = name | STP_SQUARE_SECOND;
                if (column >= 0 && !joined && any(stp_square_quarters(c, first)))
                    stp_set_add(quartered_cells, 9 * (row + 1) + column);
                before = now;
            }
        }
    }
    draws[square] = stp_square_draw(3u * (end - next), 1u, 3u * next, 0u);
    stp_quartered_add(square, quartered_cells);
}
