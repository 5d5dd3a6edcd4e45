/* Finds the tiles of the picture that a cut may cover, so that screen-space passes skip the rest.
 *
 * Tiles are squares of STP_TILE_PX pixels. A pass draws the tiles of this frame and of the last
 * frame. So it clears pixels that were covered in the last frame only, all textures of the pyramid
 * stay empty outside the frame's tiles, and none needs clearing. Threads: the render thread. */
#ifndef STP_RUNTIME_CUT_TILES_H
#define STP_RUNTIME_CUT_TILES_H

#include "base/error.h"

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_TILE_PX 8
/* So many levels of the pyramid are drawn by tiles. Higher levels are small and drawn whole. */
#define STP_TILE_LEVELS 4

/* A rectangle of pixels of a pyramid level: x0 <= x < x1, y0 <= y < y1. */
typedef struct stp_tile_rect {
    int x0, y0, x1, y1;
} stp_tile_rect;

/* Zero is no picture. */
typedef struct stp_tiles {
    int width, height; /* of the picture */
    int columns, rows;
    size_t count;
    uint8_t *now, *last; /* row by row, 1: may be covered. last: in this frame or the one before */
    uint8_t *marks;      /* as `now`, per worker: the marks of this pass */
    unsigned workers;
    int known_levels;     /* pyramid levels that are empty outside `last`; -1: not even level 0 */
    bool drawn;           /* stp_tiles_set_levels was called for this frame */
    bool whole;           /* draw everything above level 0 */
    GLuint array;         /* of no attributes */
    stp_tile_rect *rects; /* without overlap, cover what `last` needs of each level */
    size_t rect_count, rect_capacity, level_begin[STP_TILE_LEVELS + 1];
    uint8_t *cells; /* of one level, 1: needed */
} stp_tiles;

/* Begins a frame of this size. A new size forgets the last frame. workers: number of threads that
 * mark, the same in every frame. Errors: OUT_OF_MEMORY. */
stp_status stp_tiles_begin(stp_tiles *tiles, int width, int height, unsigned workers,
                           stp_error *err);
/* Mark the tiles that a disc of `reach` pixels around a window position may cover, or all tiles.
 * Threads: each worker passes its own number. */
void stp_tiles_mark(stp_tiles *tiles, unsigned worker, float x, float y, float reach);
/* Whether the worker has marked all that a disc may cover whose square of 2 `reach` pixels lies in
 * a rectangle of window coordinates. */
bool stp_tiles_marked(const stp_tiles *tiles, unsigned worker, const float low[2],
                      const float high[2]);
/* Marks the tiles of the frame before. Call before any other mark of this one. */
void stp_tiles_mark_again(stp_tiles *tiles);
void stp_tiles_mark_all(stp_tiles *tiles, unsigned worker);
/* Adds the marks to the frame's tiles. first: the first pass of the frame, which discards the tiles
 * of earlier passes. Errors: OUT_OF_MEMORY. */
stp_status stp_tiles_collect(stp_tiles *tiles, bool first, stp_error *err);
/* Sets how many levels above the viewport the frame's pyramid has. Call before drawing a level. */
void stp_tiles_set_levels(stp_tiles *tiles, int levels);
void stp_tiles_destroy(stp_tiles *tiles);

/* Pixels of level l along a side that has viewport_px pixels at level 0. */
int stp_tiles_level_px(int viewport_px, int l);
/* The rectangles of level l to draw: those of the tiles, or one for the whole level, stored in
 * *whole. Returns their number. */
size_t stp_tiles_rects(const stp_tiles *tiles, int l, stp_tile_rect *whole,
                       const stp_tile_rect **rects);
/* Draw with the program in use: the tiles of level l of the pyramid, or all of level l. A level's
 * tiles include the neighbours that finishing the level below reads. */
void stp_tiles_draw(const stp_tiles *tiles, int l);
void stp_tiles_draw_whole(const stp_tiles *tiles, int l);
/* Draws one pixel of level 0. */
void stp_tiles_draw_pixel(const stp_tiles *tiles, int x, int y);

#endif
