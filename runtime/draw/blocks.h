/* The tiles of the picture as blocks of pixels, for the compute shaders that pull and finish
 * them (shaders/reconstruct/blocks.glsl). What rasterised passes draw of a level is what these
 * write of it: no pixel more, so that outside a frame's tiles all stays empty. Threads: the render
 * thread. */
#ifndef STP_RUNTIME_DRAW_BLOCKS_H
#define STP_RUNTIME_DRAW_BLOCKS_H

#include "base/error.h"
#include "runtime/cut/tiles.h"
#include "runtime/draw/pyramid.h"

#include <epoxy/gl.h>
#include <stddef.h>
#include <stdint.h>

/* x | y << 16 of a block, in blocks, and which of its cells are wanted. */
typedef struct stp_block {
    uint32_t place, cells;
} stp_block;

/* Zero is none. */
typedef struct stp_blocks {
    GLuint buffer;
    stp_block *items; /* level by level */
    size_t capacity, begin[STP_PYRAMID_LEVELS_LIMIT + 1];
    uint16_t *cells; /* of one level, by block */
    size_t cell_capacity;
} stp_blocks;

/* Lists the blocks of levels 0..levels - 1 that the tiles are drawn in. Errors: OUT_OF_MEMORY. */
stp_status stp_blocks_list(stp_blocks *blocks, const stp_tiles *tiles, int levels, stp_error *err);
/* Runs the program in use, which includes shaders/reconstruct/blocks.glsl, on those of a level. */
void stp_blocks_run(const stp_blocks *blocks, const stp_pyramid_level *level, int l);
void stp_blocks_destroy(stp_blocks *blocks);

#endif
