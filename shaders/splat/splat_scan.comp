// Splatting, second step: turns the counts of bins into the places where their lists begin. Step 0
// adds up each block of bins, step 1 the blocks, step 2 the bins within each block.
#include "layout.glsl"
#include "splat_bins.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 4) buffer stp_bins_block {
    uint levels_used;
    uint total;
    uint spare[2];
    uint bins[]; // followed by the sums of blocks
};

layout(location = 1) uniform uint step;
layout(location = 4) uniform uint bin_count; // without the sums of blocks

// Prefix sum in place: each item becomes the sum of the items before it.
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
