// The blocks of a level that compute shaders pull and finish, with a row of invocations each
// (runtime/draw/pixel_blocks.c).

#define STP_BLOCK_SIZE ivec2(16, 8)
#define STP_BLOCK_CELL_COLUMNS 5
#define STP_BLOCK_LANES 8 // next to each other in a block: a software driver computes so many at once
#define STP_BLOCKS_A_GROUP 4

layout(local_size_x = STP_BLOCK_LANES, local_size_y = STP_BLOCKS_A_GROUP) in;

// A block: x | y << 16, and a bit set that says which of its cells of 4 x 4 pixels are wanted. The
// first block begins at pixel -1, so that pixels 2 x - 1 and 2 x, which push from the same coarse
// pixels, lie in one block. So a block touches 5 x 3 cells.
layout(std430, binding = 1) readonly buffer stp_blocks_block {
    uvec2 blocks[];
};

layout(location = 5) uniform uvec2 listed;    // blocks of this level: first, end
layout(location = 7) uniform ivec2 level_size;

// The block of this invocation; without cells if there are no more blocks.
uvec2 stp_block()
{
    uint index = listed.x + (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * STP_BLOCKS_A_GROUP +
                 gl_LocalInvocationID.y;
    return index < listed.y ? blocks[index] : uvec2(0u);
}

// The first pixel of a block.
ivec2 stp_block_place(uvec2 block)
{
    return ivec2(block.x & 65535u, block.x >> 16) * STP_BLOCK_SIZE - 1;
}

bool stp_block_wants(uvec2 block, ivec2 in_block)
{
    ivec2 cell = in_block + 3 >> 2;
    bool there = all(lessThan(stp_block_place(block) + in_block, level_size));
    return there && (block.y >> uint(cell.x + STP_BLOCK_CELL_COLUMNS * cell.y) & 1u) != 0u;
}
