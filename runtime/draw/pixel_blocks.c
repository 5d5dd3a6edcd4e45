/* Turns rectangles of tiles into blocks. */
#include "runtime/draw/pixel_blocks.h"

#include "base/memory.h"
#include "runtime/gl/gpu_layout.h"

#include <stdlib.h>
#include <string.h>

/* The same as in shaders/reconstruct/blocks.glsl. */
#define BLOCK_WIDTH_PX 16
#define BLOCK_HEIGHT_PX 8
#define BLOCK_CELL_PX 4
#define BLOCK_CELL_COLUMNS 5
#define BLOCKS_A_GROUP 4u
#define BLOCKS_BINDING 1

/* Some drivers do not allow more groups in a row. */
#define ROW_GROUPS 32768u

/* The block that holds a pixel along one axis; block 0 begins at pixel -1. */
static int block_of(int px, int block_px)
{
    return (px + 1) / block_px;
}

/* The cell of a pixel within its block, along one axis. */
static int cell_of(int px, int block_px)
{
    return px / BLOCK_CELL_PX - block_of(px, block_px) * (block_px / BLOCK_CELL_PX) + 1;
}

static void mark_pixel(stp_pixel_blocks *b, int x, int y, int columns)
{
    int block = block_of(y, BLOCK_HEIGHT_PX) * columns + block_of(x, BLOCK_WIDTH_PX);
    int cell = cell_of(y, BLOCK_HEIGHT_PX) * BLOCK_CELL_COLUMNS + cell_of(x, BLOCK_WIDTH_PX);
    b->cells[block] |= (uint16_t)(1u << cell);
}

/* Marks the cells of a rectangle in all blocks that it touches. A rectangle begins where a cell
 * begins. */
static void mark(stp_pixel_blocks *b, const stp_tile_rect *rect, int columns)
{
    for (int y = rect->y0; y < rect->y1; y += BLOCK_CELL_PX)
        for (int x = rect->x0; x < rect->x1; x += BLOCK_CELL_PX) {
            int last_x = x + BLOCK_CELL_PX < rect->x1 ? x + BLOCK_CELL_PX - 1 : rect->x1 - 1;
            int last_y = y + BLOCK_CELL_PX < rect->y1 ? y + BLOCK_CELL_PX - 1 : rect->y1 - 1;
            mark_pixel(b, x, y, columns);
            mark_pixel(b, last_x, y, columns);
            mark_pixel(b, x, last_y, columns);
            mark_pixel(b, last_x, last_y, columns);
        }
}

static stp_status list_level(stp_pixel_blocks *b, const stp_tiles *tiles, int l, stp_error *err)
{
    stp_status status = STP_OK;
    stp_tile_rect whole;
    const stp_tile_rect *rects;
    size_t rect_count = stp_tiles_rects(tiles, l, &whole, &rects), count = b->begin[l];
    int columns = block_of(stp_tiles_level_px(tiles->width, l) - 1, BLOCK_WIDTH_PX) + 1;
    int rows = block_of(stp_tiles_level_px(tiles->height, l) - 1, BLOCK_HEIGHT_PX) + 1;
    size_t most = (size_t)columns * (size_t)rows;
    STP_TRY(
        stp_grow(&b->cells, &b->cell_capacity, most, sizeof *b->cells, "blocks of pixels", err));
    STP_TRY(
        stp_grow(&b->items, &b->capacity, count + most, sizeof *b->items, "blocks of pixels", err));
    memset(b->cells, 0, most * sizeof *b->cells);
    for (size_t i = 0; i < rect_count; i++)
        mark(b, &rects[i], columns);
    for (int y = 0, i = 0; y < rows; y++)
        for (int x = 0; x < columns; x++, i++)
            if (b->cells[i] != 0)
                b->items[count++] = (stp_pixel_block){(uint32_t)x | (uint32_t)y << 16, b->cells[i]};
    b->begin[l + 1] = count;
done:
    return status;
}

stp_status stp_pixel_blocks_list(stp_pixel_blocks *b, const stp_tiles *tiles, int levels,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    for (int l = 0; l < levels && l < STP_PYRAMID_LEVELS_LIMIT; l++)
        STP_TRY(list_level(b, tiles, l, err));
    if (b->buffer == 0)
        glCreateBuffers(1, &b->buffer);
    glNamedBufferData(b->buffer, (GLsizeiptr)(b->begin[levels] * sizeof *b->items), b->items,
                      GL_STREAM_DRAW);
done:
    return status;
}

void stp_pixel_blocks_run(const stp_pixel_blocks *b, const stp_pyramid_level *level, int l)
{
    GLuint count = (GLuint)(b->begin[l + 1] - b->begin[l]);
    GLuint groups = (count + BLOCKS_A_GROUP - 1) / BLOCKS_A_GROUP;
    GLuint row = groups < ROW_GROUPS ? groups : ROW_GROUPS;
    if (count == 0)
        return;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, BLOCKS_BINDING, b->buffer);
    glUniform2ui(STP_UNIFORM_BLOCKS, (GLuint)b->begin[l], (GLuint)b->begin[l + 1]);
    glUniform2i(STP_UNIFORM_LEVEL_SIZE, level->width, level->height);
    glDispatchCompute(row, (groups + row - 1) / row, 1);
}

void stp_pixel_blocks_destroy(stp_pixel_blocks *b)
{
    if (b->buffer != 0)
        glDeleteBuffers(1, &b->buffer);
    free(b->items);
    free(b->cells);
    *b = (stp_pixel_blocks){0};
}
