/* Draws smooth edges for --aa: averages finer pictures, which are also the reference for smooth
 * edges. Threads: the render thread. */
#ifndef STP_TOOLS_DRAW_DRAW_FINE_H
#define STP_TOOLS_DRAW_DRAW_FINE_H

#include "formats/image/image.h"
#include "runtime/stipple.h"

/* The words of --aa, and the indices of two. */
#define DRAW_AA "none|edges|2|3|4"
#define DRAW_AA_NONE 0
#define DRAW_AA_EDGES 1

/* How many times finer --aa draws pictures; 1 if it does not. */
int draw_aa_times(int aa);

/* Converts premultiplied colours to straight alpha, as files have them. */
void draw_straighten(stp_image *image);
/* Draws the view with times x times as many pixels, part by part, and averages them. The threshold
 * keeps its value in the finer pixels. rgba: width * height * 4 bytes, bottom row first,
 * premultiplied. stats: sums over the parts. The renderer's own last picture is one of the parts.
 * Errors: those of stp_renderer_draw and stp_renderer_read. */
stp_status draw_fine(stp_renderer *renderer, const stp_view *view, const stp_draw_params *params,
                     int times, uint8_t *rgba, stp_draw_stats *stats, stp_error *err);

#endif
