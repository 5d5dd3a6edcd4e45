// Writes the quarters of cells that square.comp lists, one invocation a cell.
#define STP_FRAME_HELD
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "square.glsl"
#include "pieces.glsl"

layout(local_size_x = STP_QUARTER_GROUP) in;

// The corners of a cell's quarter, from its sample `own` on: the next along columns, along rows, and
// across. sides: stp_square_sides.
vec3[4] stp_square_quarter(stp_square_corner c[4], bvec4 sides, int own)
{
    int by_column = own ^ 1, by_row = own ^ 2, across = own ^ 3;
    bool column = sides[own >> 1], row = sides[2 + (own & 1)];
    bool far_column = sides[1 - (own >> 1)], far_row = sides[3 - (own & 1)];
    // Which samples the surface joins to the own one within the cell.
    bool joined[4];
    joined[own] = true;
    joined[by_column] = column || row && far_row && far_column;
    joined[by_row] = row || column && far_row && far_column;
    joined[across] = column && far_row || row && far_column;
    vec3 place = c[own].place, middle = vec3(0.0);
    float count = 0.0;
    for (int i = 0; i < 4; i++) {
        vec3 at = c[i].place + ((i & 1) != 0 ? -c[i].by_column : c[i].by_column) +
                  ((i & 2) != 0 ? -c[i].by_row : c[i].by_row);
        middle += joined[i] ? at : vec3(0.0);
        count += joined[i] ? 1.0 : 0.0;
    }
    vec3 half_column = (own & 1) != 0 ? -c[own].by_column : c[own].by_column;
    vec3 half_row = (own & 2) != 0 ? -c[own].by_row : c[own].by_row;
    return vec3[](place, column ? 0.5 * (place + c[by_column].place) : place + half_column,
                  row ? 0.5 * (place + c[by_row].place) : place + half_row, middle / count);
}

// A place relative to the eye, moved away from it.
vec3 stp_square_behind(vec3 place, float by)
{
    vec3 back = vec3(axis_right.w, axis_up.w, axis_back.w);
    return place - by * (STP_ORTHOGRAPHIC != 0 ? back : -normalize(place));
}

void main()
{
    stp_frame_hold();
    if (gl_GlobalInvocationID.x >= quartered_count)
        return;
    uint entry = quartered[gl_GlobalInvocationID.x], piece = entry >> 7;
    uint listed = first_square + piece / STP_SQUARE_PIECES;
    bool of_map = (stp_square_flags(listed) & STP_SQUARE_OF_MAP) != 0u;
    ivec2 first = stp_cell_first(entry & 127u);
    stp_square_axes axes = stp_square_axes_fetch(listed);
    stp_square_corner c[4];
    for (int i = 0; i < 4; i++)
        c[i] = stp_square_corner_at(listed, first + ivec2(i & 1, i >> 1), axes);
    bvec4 sides = stp_square_sides(c, of_map), quarters = stp_square_quarters(c, first);
    for (int own = 0; own < 4; own++) {
        if (!quarters[own])
            continue;
        // Quarters of maps show where no cell of another map, and no triangle between them, is drawn.
        float behind = of_map ? 2.0 * length(c[own].by_column) : 0.0;
        vec3 places[4] = stp_square_quarter(c, sides, own);
        for (int i = 0; i < 4; i++)
            places[i] = stp_square_behind(places[i], behind);
        stp_piece_write(piece++, places, listed, first + ivec2(own & 1, own >> 1), 0u);
    }
}
