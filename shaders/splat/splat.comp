// Splatting, first step. One pass counts the splats of each bin, another
// pass writes the lists.
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
#include "sample_pixel.glsl"
#include "runs.glsl"
#include "listed.glsl"
#include "splat_bins.glsl"
#include "splat_bound.glsl"

layout(std430, binding = 4) buffer stp_bins_block {
    uint levels_used; // bit set
    uint spare[3];
    uint bins[]; // first counts, then where lists begin, then where lists end
};

// Two vec4 for each splat of a bin. First: window position, 1 / radius in pixels, depth. Second:
// normal x and y; depth of the interval with the sign of the normal's z; number of the splat.
layout(std430, binding = 5) writeonly buffer stp_lists_block {
    vec4 lists[];
};

layout(std430, binding = 6) writeonly buffer stp_looks_block {
    uvec2 looks[]; // by splat: colour, sample
};

layout(location = 1) uniform bool listing;
layout(location = 5) uniform uint first_splat; // number of the splat at place 0

uint stp_splat_colour_pack(vec3 colour)
{
    uvec3 code = uvec3(clamp(colour, 0.0, 1.0) * vec3(2047.0, 2047.0, 1023.0) + 0.5);
    return code.r | code.g << 11 | code.b << 22;
}

void stp_bin_add(uint bin, stp_splat s, uint splat)
{
    uint at = 2u * atomicAdd(bins[bin], 1u);
    if (!listing)
        return;
    lists[at] = s.place;
    lists[at + 1u] = vec4(s.normal.xy, s.normal.z < 0.0 ? -s.extent : s.extent, uintBitsToFloat(splat));
}

// Adds a splat to the bins that its bounding box touches.
void stp_splat_list(stp_splat s, uint splat)
{
    vec2 size = stp_splat_size(s);
    ivec4 pixels = stp_splat_pixels(s, size);
    if (pixels.x > pixels.z || pixels.y > pixels.w)
        return;
    float wide = max(size.x, size.y) / STP_BIN_REACH;
    int level = int(min(ceil(log2(max(wide, 1.0))), float(stp_bin_top())));
    int begin = 0;
    for (int l = 0; l < level; l++) {
        ivec2 grid = stp_bin_grid(l);
        begin += grid.x * grid.y;
    }
    ivec2 bits = STP_BIN_BITS + level;
    ivec4 touched = pixels >> bits.xyxy;
    int columns = stp_bin_grid(level).x;
    for (int row = touched.y; row <= touched.w; row++)
        for (int column = touched.x; column <= touched.z; column++)
            stp_bin_add(uint(begin + row * columns + column), s, splat);
    if ((levels_used >> level & 1u) == 0u)
        atomicOr(levels_used, 1u << level);
}

void stp_splat_visit(stp_projected s, uint splat)
{
    ivec2 pixel;
    float z;
    uvec4 texel = texelFetch(object_texture, int(s.index));
    if (!stp_place(texel, s.lattice.xyz, s.lattice.w, s.openings, pixel, z))
        return;
    uvec2 id = uvec2(s.index, texelFetch(patch_of_sample, int(s.index)).x);
    stp_pixel p = stp_disc_pixel(stp_disc_alone(stp_disc_decode(texel, s.lattice.xyz, s.lattice.w)), id.x, id,
                                 vec2(0.0));
    float radius_px = max(p.radius * stp_pixels_per_unit(p.z_min), STP_ELLIPSE_FLOOR);
    stp_splat disc = stp_splat(vec4(p.d, 1.0 / radius_px, p.z_min), p.normal, p.z_max - p.z_min);
    if (p.radius <= 0.0) // covers only its own pixel
        disc.place.xyz = vec3(vec2(pixel) + 0.5, 1e6);
    if (listing)
        looks[splat] = uvec2(stp_splat_colour_pack(p.colour), s.index);
    stp_splat_list(disc, splat);
}

void main()
{
    stp_frame_hold();
    uint end = stp_end_place();
    for (uint place = stp_first_place(); place < end; place += STP_PLACE_STEP) {
        stp_projected s;
        if (stp_find(place, s))
            stp_splat_visit(s, first_splat + place);
    }
}
