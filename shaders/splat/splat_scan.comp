// Splatting, second step: counts of bins become where they begin. Blocks of bins are added up, then the blocks,
// then each block's bins.
#include "layout.glsl"
#include "splat_bins.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 4) buffer stp_bins_block {
    uint levels_used;
    uint total;
    uint spare[2];
    uint bins[]; // and then the blocks' sums
};

layout(location = 1) uniform uint step;
layout(location = 4) uniform uint bin_count; // without the sums

// Adds up items in place, from the first on: each becomes the sum of those before it.
uint stp_scan(uint begin, uint end, uint sum)
{
    for (uint i = begin; i < end; i++) {
        uint count = bins[i];
        bins[i] = sum;
        sum += count;
    }
    return sum;
}

void main()
{
    uint block = gl_GlobalInvocationID.x;
    uint block_size = max(64u, (bin_count + STP_BIN_BLOCKS - 1u) / STP_BIN_BLOCKS);
    uint blocks = (bin_count + block_size - 1u) / block_size;
    uint begin = block * block_size, end = min(begin + block_size, bin_count);
    if (block >= blocks)
        return;
    if (step == 0u) {
        uint sum = 0u;
        for (uint i = begin; i < end; i++)
            sum += bins[i];
        bins[bin_count + block] = sum;
    } else if (step == 1u && block == 0u) {
        total = stp_scan(bin_count, bin_count + blocks, 0u);
    } else if (step == 2u) {
        stp_scan(begin, end, bins[bin_count + block]);
    }
}
