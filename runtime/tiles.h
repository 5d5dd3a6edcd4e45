/* The tiles of the picture that a cut may cover, so that screen-space passes leave the rest alone.
 *
 * Tiles are STP_TILE_PX pixels square. A pass draws the tiles of this frame and of the last one:
 * those write emptiness where something was, so that outside the frame's tiles all textures of the
 * pyramid stay empty and need no clearing. Threads: the render thread. */
#ifndef STP_RUNTIME_TILES_H
#define STP_RUNTIME_TILES_H

#include "runtime/chunk_cache.h"
#include "runtime/cut.h"

#include <epoxy/gl.h>

#define STP_TILE_PX 16
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
    uint8_t *now, *last; /* 1: may be covered, row by row; last: in this frame or the one before */
    int known_levels;    /* pyramid levels that hold nothing outside `last`; -1: not even level 0 */
    bool drawn;          /* the frame came so far that its levels were told */
    bool whole;          /* draw everything above level 0 */
    GLuint array;        /* of no attributes */
    stp_tile_rect *rects; /* that cover what `last` needs of each level, none twice */
    size_t rect_count, rect_capacity, level_begin[STP_TILE_LEVELS + 1];
    uint8_t *cells; /* of one level: 1 where it is needed */
} stp_tiles;

/* What the tiles of a draw depend on, beside the draw. */
typedef struct stp_tiles_source {
    const stp_model *model;
    const stp_chunk_cache *cache;
    const stp_view *view;
} stp_tiles_source;

/* Begins a frame of this size; a new size forgets the last frame. Errors: OUT_OF_MEMORY. */
stp_status stp_tiles_begin(stp_tiles *tiles, int width, int height, stp_error *err);
/* Adds what resident chunks may cover. first: they are the first of the frame, which may begin
 * anew. Errors: OUT_OF_MEMORY. */
stp_status stp_tiles_add(stp_tiles *tiles, const stp_tiles_source *source, const stp_draw *draws,
                         size_t count, bool first, stp_error *err);
/* Says how many levels above the viewport the frame's pyramid has, before the first is drawn. */
void stp_tiles_set_levels(stp_tiles *tiles, int levels);
void stp_tiles_destroy(stp_tiles *tiles);

/* Draws the tiles in level l of the pyramid, or all of it, with the program in use. Each level's
 * hold also what finishing those of the level below reads beside them. */
void stp_tiles_draw(const stp_tiles *tiles, int l);
void stp_tiles_draw_whole(const stp_tiles *tiles, int l);

#endif
