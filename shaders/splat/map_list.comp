// Splats of elevation maps, first step: lists those of each square, one group of invocations a square.
#define STP_FRAME_HELD
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "choose.glsl"
#include "palette.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "square.glsl"
#include "shape.glsl"
#include "map.glsl"
#include "sample_pixel.glsl"
#include "splat_bins.glsl"
#include "splat_bound.glsl"
#include "splat_list.glsl"

layout(local_size_x = 64) in;

layout(location = 4) uniform uvec2 squares; // the first, and one past the last

// Which triangles between a sample and its neighbours have their three samples: bit
// stp_map_triangle(...) for each.
uint stp_map_triangles(uint listed, ivec2 at)
{
    uint there = 0u, triangles = 0u;
    int places = listing ? 9 : 0; // counting needs none; a software driver skips loops, but no branch
    for (int i = 0; i < places; i++)
        there |= uint(stp_square_there(listed, at + ivec2(i % 3, i / 3) - 1)) << i;
    for (int i = 0; i < places - 1; i++) {
        int first = (i & 1) + 3 * (i >> 1 & 1);             // the cell's first sample
        uint needed = (i < 4 ? 11u : 26u) << first;         // 0, 1, 3 or 1, 3, 4 from there
        triangles |= uint((there & needed) == needed) << i;
    }
    return triangles;
}

void main()
{
    stp_frame_hold();
    uint listed = squares.x + gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint place = gl_LocalInvocationID.x;
    ivec2 at = stp_square_at(place);
    if (listed >= squares.y)
        return;
    stp_square_sample s = stp_square_sample_at(listed, at);
    uint patch_index = stp_square_fetch(listed).patch_index;
    stp_disc disc = stp_disc_decode(s.texel, s.lattice.xyz, s.lattice.w);
    if (!s.there || -disc.position.z <= viewport.w || stp_clipped(s.place) ||
        stp_culled(s.texel, s.place, stp_chunk_openings(stp_patch_slot(patch_index))))
        return;
    disc.radius *= STP_MAP_RADIUS_PART;
    stp_pixel p = stp_disc_pixel(disc, STP_NAME_SQUARE, stp_name_of(patch_index, 0, 0u), vec2(0.0));
    float radius_px = max(p.radius * stp_pixels_per_unit(p.z_min), STP_MAP_FLOOR);
    stp_splat splat = stp_splat(vec4(p.d, 1.0 / radius_px, p.z_min), p.normal, p.z_max - p.z_min);
    uint number = listed << 6 | place;
    // The last bits of the interval tell of neighbours.
    splat.extent = uintBitsToFloat(floatBitsToUint(splat.extent) & ~255u | stp_map_triangles(listed, at));
    if (listing)
        looks[number] = uvec2(stp_splat_colour_pack(p.colour), 0u);
    stp_splat_list(splat, number);
}
