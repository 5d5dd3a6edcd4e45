/* The second of two settings or models that are shown beside each other: the text of --beside, as
 * "N.stipple", "--threshold 4 --shade unlit", or a path and then options. Threads: the main thread
 * only. */
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
 * options of the first side, checked or not. Returns CLI_CONTINUE, or prints a message (or, for
 * --help, these options) and returns an exit code. */
int draw_beside_parse(draw_beside *out, const char *text, const draw_options *first);
void draw_beside_clear(draw_beside *beside);

#endif
