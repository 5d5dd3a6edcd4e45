// Emits the cells of a square of a grid as triangles (square.glsl): those that begin in the square if
// the surface joins their samples, else the quarters at the square's samples. Instanced: each
// invocation emits its share.
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "square.glsl"
#include "corner.glsl"

#define STP_SQUARE_INVOCATIONS 27
#define STP_SQUARE_SHARE (9 * 9 / STP_SQUARE_INVOCATIONS)

layout(points, invocations = STP_SQUARE_INVOCATIONS) in;
layout(triangle_strip, max_vertices = 16 * STP_SQUARE_SHARE) out;

flat in uint patch_index[]; // the number of the square among those drawn

void stp_piece_emit(vec3 corners[4], ivec2 at, uint which)
{
    uint place = stp_square_place(uvec2(at));
    uint name = STP_NAME_SQUARE | patch_index[0] << STP_NAME_SQUARE_SHIFT | place << STP_NAME_PLACE_SHIFT | which;
    for (int i = 0; i < 4; i++) // a triangle has the name of its last corner
        stp_corner_emit(corners[i], i < 3 ? name : name | STP_SQUARE_SECOND);
    EndPrimitive();
}

// A place relative to the eye, moved away from it.
vec3 stp_square_behind(vec3 place, float by)
{
    vec3 back = vec3(axis_right.w, axis_up.w, axis_back.w);
    return place - by * (STP_ORTHOGRAPHIC != 0 ? back : -normalize(place));
}

// first: column and row of the cell's first sample.
void stp_cell_emit(ivec2 first, stp_square_axes axes, uint flags)
{
    stp_square_cell c = stp_square_cell_fetch(patch_index[0], first);
    stp_square_surface s = stp_square_surface_find(c, axes, (flags & STP_SQUARE_OF_MAP) != 0u);
    if (all(s.sides) && min(first.x, first.y) >= 0)
        stp_piece_emit(vec3[](c.samples[0].place, c.samples[1].place, c.samples[2].place, c.samples[3].place), first,
                       STP_SQUARE_WHOLE);
    // A software driver runs both sides of a branch, but skips loops.
    int quarters = all(s.sides) ? 0 : 4;
    for (int own = 0; own < quarters; own++) {
        ivec2 at = first + ivec2(own & 1, own >> 1);
        if (!c.samples[own].there || at >> 3 != ivec2(0))
            continue;
        // Triangles lie in front of quarters, which show where these are not drawn.
        vec3 corners[4] = stp_square_quarter(c, s, own);
        float behind = (flags & STP_SQUARE_FILLED) != 0u ? length(s.by_column[own]) : 0.0;
        for (int i = 0; i < 4; i++)
            corners[i] = stp_square_behind(corners[i], behind);
        stp_piece_emit(corners, at, 0u);
    }
}

void main()
{
    stp_square_axes axes = stp_square_axes_fetch(patch_index[0]);
    uint flags = stp_square_flags(patch_index[0]);
    for (int i = 0; i < STP_SQUARE_SHARE; i++) {
        int cell = gl_InvocationID * STP_SQUARE_SHARE + i;
        stp_cell_emit(ivec2(cell % 9, cell / 9) - 1, axes, flags);
    }
}
