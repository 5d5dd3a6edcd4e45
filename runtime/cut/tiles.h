/* The tiles of the picture that a cut may cover, so that screen-space passes leave the rest alone.
 *
 * Tiles are STP_TILE_PX pixels square. A pass draws the tiles of this frame and of the last one:
 * those write emptiness where something was, so that outside the frame's tiles all textures of the
 * pyramid stay empty and need no clearing. Threads: the render thread. */
#ifndef STP_RUNTIME_CUT_TILES_H
#define STP_RUNTIME_CUT_TILES_H

#include "base/error.h"

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_TILE_PX 8
/* Levels of the pyramid drawn by tiles; higher ones, which are small, are drawn as a whole. */
#define STP_TILE_LEVELS 4

/* Pixels of a level of the pyramid, without the last column and row. */
typedef struct stp_tile_rect {
    int x0, y0, x1, y1;
} stp_tile_rect;

/* Zero is no picture. */
typedef struct stp_tiles {
    int width, height; /* of the picture */
    int columns, rows;
    size_t count;
    uint8_t *now, *last; /* 1: may be covered, row by row; last: in this frame or the one before */
    uint8_t *marks;      /* as now, for each worker: what it found in this pass */
    unsigned workers;
    int known_levels; /* pyramid levels that hold nothing outside `last`; -1: not even level 0 */
    bool drawn;       /* the frame came so far that its levels were told */
    bool whole;       /* draw everything above level 0 */
    GLuint array;     /* of no attributes */
    stp_tile_rect *rects; /* that cover what `last` needs of each level, none twice */
    size_t rect_count, rect_capacity, level_begin[STP_TILE_LEVELS + 1];
    uint8_t *cells; /* of one level: 1 where it is needed */
} stp_tiles;

/* Begins a frame of this size; a new size forgets the last frame. workers: threads that mark, the
 * same in every frame. Errors: OUT_OF_MEMORY. */
stp_status stp_tiles_begin(stp_tiles *tiles, int width, int height, unsigned workers,
                           stp_error *err);
/* Marks what a disc of `reach` pixels around a window position may cover, or everything. Threads:
 * each worker its own. */
void stp_tiles_mark(stp_tiles *tiles, unsigned worker, float x, float y, float reach);
void stp_tiles_mark_all(stp_tiles *tiles, unsigned worker);
/* Adds what was marked to the frame's tiles. first: it is the first of the frame, which may begin
 * anew. Errors: OUT_OF_MEMORY. */
stp_status stp_tiles_collect(stp_tiles *tiles, bool first, stp_error *err);
/* Says how many levels above the viewport the frame's pyramid has, before the first is drawn. */
void stp_tiles_set_levels(stp_tiles *tiles, int levels);
void stp_tiles_destroy(stp_tiles *tiles);

/* Pixels of level l along a side of so many. */
int stp_tiles_level_px(int viewport_px, int l);
/* The rectangles of level l that are drawn: of the tiles, or all of it, for which *whole is room.
 * Returns how many. */
size_t stp_tiles_rects(const stp_tiles *tiles, int l, stp_tile_rect *whole,
                       const stp_tile_rect **rects);
/* Draws the tiles in level l of the pyramid, or all of it, with the program in use. Each level's
 * hold also what finishing those of the level below reads beside them. */
void stp_tiles_draw(const stp_tiles *tiles, int l);
void stp_tiles_draw_whole(const stp_tiles *tiles, int l);
/* Draws one pixel of level 0. */
void stp_tiles_draw_pixel(const stp_tiles *tiles, int x, int y);

#endif
