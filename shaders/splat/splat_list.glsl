// Lists splats by bins. One pass counts the splats of each bin, another writes the lists. Needs layout.glsl,
// splat_bins.glsl, splat_bound.glsl. runtime/draw/splat.c makes the buffers.

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
