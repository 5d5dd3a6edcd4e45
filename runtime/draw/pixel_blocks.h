/* Lists the tiles of the picture as blocks of pixels, for the compute shaders that pull and finish
 * (shaders/reconstruct/blocks.glsl). These shaders write exactly the pixels of a level that the
 * rasterised passes draw, so everything outside a frame's tiles stays empty. Threads: the render
 * thread. */
#ifndef STP_RUNTIME_DRAW_PIXEL_BLOCKS_H
#define STP_RUNTIME_DRAW_PIXEL_BLOCKS_H

#include "base/error.h"
#include "runtime/cut/tiles.h"
#include "runtime/draw/pyramid.h"

#include <epoxy/gl.h>
#include <stddef.h>
#include <stdint.h>

/* place: x | y << 16, in blocks; cells: which cells of the block are wanted. */
typedef struct stp_pixel_block {
    uint32_t place, cells;
} stp_pixel_block;

/* Zero: no blocks. */
typedef struct stp_pixel_blocks {
    GLuint buffer;
    stp_pixel_block *items; /* level by level */
    size_t capacity, begin[STP_PYRAMID_LEVELS_LIMIT + 1];
    uint16_t *cells; /* of one level, by block */
    size_t cell_capacity;
} stp_pixel_blocks;

/* Lists the blocks of levels 0..levels - 1 that the tiles cover. Errors: OUT_OF_MEMORY. */
stp_status stp_pixel_blocks_list(stp_pixel_blocks *blocks, const stp_tiles *tiles, int levels,
                                 stp_error *err);
/* Runs the program in use, which includes blocks.glsl, on the blocks of level l. */
void stp_pixel_blocks_run(const stp_pixel_blocks *blocks, const stp_pyramid_level *level, int l);
void stp_pixel_blocks_destroy(stp_pixel_blocks *blocks);

#endif
