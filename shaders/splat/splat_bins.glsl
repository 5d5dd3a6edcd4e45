// Rectangles of the picture, bins, each with a list of the splats that may cover a pixel of it. Level l of the grid has
// bins of 4 x 2 pixels times 2^l; a splat is listed on the first level where it reaches no farther than STP_BIN_REACH
// times 2^l pixels, so in a few bins. A pixel looks at its own bin of each level. Needs layout.glsl. runtime/draw/splat.c
// makes the buffers.

#define STP_BIN_BITS ivec2(2, 1) // log2 of the first level's bins
#define STP_BIN_REACH 8.0
#define STP_BIN_HEAD 4           // words before the bins; the last is 0
#define STP_BIN_BLOCKS 4096u     // at most, of bins that one invocation adds up

ivec2 stp_bin_grid(int level)
{
    ivec2 bits = STP_BIN_BITS + level;
    return (ivec2(viewport.xy) + (ivec2(1) << bits) - 1) >> bits;
}

// The last level: 2^top * STP_BIN_REACH pixels hold the picture.
int stp_bin_top()
{
    int most = int(max(viewport.x, viewport.y));
    return max(findMSB(max(most - 1, 1)) - 2, 0);
}
