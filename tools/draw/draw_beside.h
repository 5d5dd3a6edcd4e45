/* The second of two settings or models that render and view show beside each other: the text of
 * --beside, as "N.stipple", "--threshold 4 --shade unlit", or a path and then options. Threads: the
 * main thread only. */
#ifndef STP_TOOLS_DRAW_DRAW_BESIDE_H
#define STP_TOOLS_DRAW_DRAW_BESIDE_H

#include "tools/draw/draw_options.h"

/* Zero is none. */
typedef struct draw_beside {
    const char *path;     /* NULL: the models are those of the first side */
    draw_options options; /* those of the first side, but for what the text changes */
    char *text;           /* owned; path and options point into it */
} draw_beside;

/* Parses the text. The options are those that change a picture without moving the camera. A path
 * ends before the first " --", so it may hold spaces; in options, quotes keep spaces. first: the
 * options of the first side, checked or not. in_view: of the viewer, not of render. Returns
 * CLI_CONTINUE, or prints a message (or, for
 * --help, these options) and returns an exit code. */
int draw_beside_parse(draw_beside *out, const char *text, const draw_options *first, bool in_view);
void draw_beside_clear(draw_beside *beside);
/* If both sides are coloured by the same numbers, and no option gives a range, gives both the range
 * of both. attributes: STP_HAS_* that the models of both sides have. */
void draw_beside_join_ranges(stp_draw_params *first, const draw_options *first_options,
                             stp_draw_params *second, const draw_options *second_options,
                             uint32_t attributes);
/* Puts the right half of a picture into another one of the same size, and a divider between: a dark
 * and a bright column. */
void draw_beside_put(uint8_t *rgba, const uint8_t *right, int width, int height);

#endif
