// Lists the quarters of cells that square.comp found, one invocation a cell, after the triangles of whole cells.
// Those of a square come in any order: they do not lie before each other.
#define STP_FRAME_HELD
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "square.glsl"
#include "pieces.glsl"
#include "square_list.glsl"

layout(local_size_x = STP_QUARTER_GROUP) in;

// A place relative to the eye, moved away from it.
vec3 stp_square_behind(vec3 place, float by)
{
    vec3 back = vec3(axis_right.w, axis_up.w, axis_back.w);
    return place - by * (STP_ORTHOGRAPHIC != 0 ? back : -normalize(place));
}

// The corners of a cell's quarter, from its sample `own` on: the next along columns, along rows, and
// across. sides: stp_square_sides. Reads no array at a number known late: a software driver would keep it in memory.
vec3[4] stp_square_quarter(stp_square_corner c[4], bvec4 sides, int own, bool of_map)
{
    bool last_column = (own & 1) != 0, last_row = (own & 2) != 0;
    bool column = last_row ? sides.y : sides.x, far_column = last_row ? sides.x : sides.y;
    bool row = last_column ? sides.w : sides.z, far_row = last_column ? sides.z : sides.w;
    // Which samples the surface joins to the own one within the cell: itself, by column, by row, across.
    bvec4 joined = bvec4(true, column || row && far_row && far_column, row || column && far_row && far_column,
                         column && far_row || row && far_column);
    joined = last_column ? joined.yxwz : joined;
    joined = last_row ? joined.zwxy : joined;
    vec3 middle = vec3(0.0);
    float count = 0.0;
    for (int i = 0; i < 4; i++) {
        vec3 at = c[i].place + ((i & 1) != 0 ? -c[i].by_column : c[i].by_column) +
                  ((i & 2) != 0 ? -c[i].by_row : c[i].by_row);
        middle += joined[i] ? at : vec3(0.0);
        count += joined[i] ? 1.0 : 0.0;
    }
    stp_square_corner low = last_column ? c[1] : c[0], high = last_column ? c[3] : c[2], here = last_row ? high : low;
    vec3 next_column = last_row ? (last_column ? c[2].place : c[3].place) : (last_column ? c[0].place : c[1].place);
    vec3 next_row = last_row ? low.place : high.place;
    vec3 half_column = last_column ? -here.by_column : here.by_column;
    vec3 half_row = last_row ? -here.by_row : here.by_row;
    vec3 corners[4] = vec3[](here.place, column ? 0.5 * (here.place + next_column) : here.place + half_column,
                             row ? 0.5 * (here.place + next_row) : here.place + half_row, middle / count);
    // Quarters of maps show where no cell of another map, and no triangle between them, is drawn.
    float behind = of_map ? 2.0 * length(here.by_column) : 0.0;
    for (int i = 0; i < 4; i++)
        corners[i] = stp_square_behind(corners[i], behind);
    return corners;
}

void stp_quarter_write(uint square, ivec2 at, vec3 corners[4])
{
    uint slot = (atomicAdd(draws[square].count, 6u) + draws[square].first) / 3u - square * STP_SQUARE_TRIANGLES;
    uint quarter = (slot - STP_CELL_TRIANGLES) / 2u;
    uint name = quarter << STP_NAME_SQUARE_SHIFT | stp_square_place(uvec2(at)) << STP_NAME_PLACE_SHIFT;
    for (uint i = 0u; i < 4u; i++)
        stp_place_write(square, uint(STP_SQUARE_CELLS) + 4u * quarter + i, corners[i]);
    triangles[square * STP_SQUARE_TRIANGLES + slot] = name;
    triangles[square * STP_SQUARE_TRIANGLES + slot + 1u] = name | STP_SQUARE_SECOND;
}

void main()
{
    stp_frame_hold();
    if (gl_GlobalInvocationID.x >= quartered_count)
        return;
    uint entry = quartered[gl_GlobalInvocationID.x], square = entry >> 7, listed = squares.x + square;
    bool of_map = (stp_square_flags(listed) & STP_SQUARE_OF_MAP) != 0u;
    ivec2 first = stp_cell_first(entry & 127u);
    stp_square_axes axes = stp_square_axes_fetch(listed);
    stp_square_corner c[4];
    for (int i = 0; i < 4; i++)
        c[i] = stp_square_corner_of(stp_square_sample_at(listed, first + ivec2(i & 1, i >> 1)), axes);
    bvec4 sides = stp_square_sides(c, of_map), quarters = stp_square_quarters(c, first);
    uint seen = 0u;
    for (int own = 0; own < 4; own++) {
        vec3 places[4] = stp_square_quarter(c, sides, own, of_map), windows[4];
        for (int i = 0; i < 4; i++)
            windows[i] = stp_place_window(places[i]);
        bool either = stp_triangle_seen(windows[0], windows[1], windows[2]) ||
                      stp_triangle_seen(windows[2], windows[1], windows[3]);
        seen |= uint(quarters[own] && either) << own;
    }
    for (; seen != 0u; seen &= seen - 1u) {
        int own = findLSB(seen);
        stp_quarter_write(square, first + ivec2(own & 1, own >> 1), stp_square_quarter(c, sides, own, of_map));
    }
}
