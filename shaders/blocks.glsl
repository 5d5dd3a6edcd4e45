// What compute shaders that pull and finish pixels work on: blocks of a level, a row of invocations each
// (runtime/blocks.c).

#define STP_BLOCK_SIZE ivec2(16, 8)
#define STP_BLOCK_LANES 8 // beside each other in a block: a software driver computes so many at once
#define STP_BLOCKS_A_GROUP 4

layout(local_size_x = STP_BLOCK_LANES, local_size_y = STP_BLOCKS_A_GROUP) in;

// x | y << 11 | cells << 23; cells: which of its 4 x 2 squares of 4 x 4 pixels are wanted.
layout(std430, binding = 1) readonly buffer stp_blocks_block {
    uint blocks[];
};

layout(location = 5) uniform uvec2 listed;    // blocks of this level: first, end
layout(location = 7) uniform ivec2 level_size;

// This invocation's, one without cells where there are no more.
uint stp_block()
{
    uint index = listed.x + (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * STP_BLOCKS_A_GROUP +
                 gl_LocalInvocationID.y;
    return index < listed.y ? blocks[index] : 0u;
}

// Its first pixel.
ivec2 stp_block_place(uint block)
{
    return ivec2(block & 2047u, block >> 11 & 4095u) * STP_BLOCK_SIZE;
}

bool stp_block_wants(uint block, ivec2 in_block)
{
    ivec2 cell = in_block >> 2;
    return (block >> uint(23 + cell.x + 4 * cell.y) & 1u) != 0u;
}
