// Bins: rectangles of the picture, each with a list of the splats that may cover one of its pixels.
// Level l of the grid has bins of (4 x 2) * 2^l pixels. A splat is listed on the first level where
// it reaches at most STP_BIN_REACH * 2^l pixels, so it is in a few bins only. A pixel looks at one
// bin of each level. Needs layout.glsl. runtime/draw/splat.c makes the buffers.

#define STP_BIN_BITS ivec2(2, 1) // log2 of the size of level 0's bins
#define STP_BIN_REACH 8.0
#define STP_BIN_HEAD 4           // words before the bins; the last is 0
#define STP_BIN_BLOCKS 4096u     // at most so many blocks; one invocation adds up the bins of a block

ivec2 stp_bin_grid(int level)
{
    ivec2 bits = STP_BIN_BITS + level;
    return (ivec2(viewport.xy) + (ivec2(1) << bits) - 1) >> bits;
}

// The last level: a reach of 2^top * STP_BIN_REACH pixels covers the picture.
int stp_bin_top()
{
    int most = int(max(viewport.x, viewport.y));
    return max(findMSB(max(most - 1, 1)) - 2, 0);
}
