/* Heights drawn higher or lower than they are: balls and cameras for such pictures. Threads: any.
 */
#ifndef STP_TOOLS_DRAW_DRAW_EXAGGERATE_H
#define STP_TOOLS_DRAW_DRAW_EXAGGERATE_H

#include "runtime/stipple.h"

/* Sets how many times as high heights are drawn, about the middle height of a box. */
void draw_exaggerate_set(stp_draw_params *params, double times, const stp_dbox *box);
stp_dbox draw_exaggerate_box(const stp_draw_params *params, const stp_dbox *box);
/* The ball of what is drawn. ball, box: of the models as they are. */
stp_ball draw_exaggerate_ball(const stp_draw_params *params, const stp_ball *ball,
                              const stp_dbox *box);
/* Moves a camera with the place that it looks at, from a world drawn with `before`, NULL: as it is,
 * to one drawn with `params`. */
void draw_exaggerate_camera(const stp_draw_params *params, const stp_draw_params *before,
                            stp_camera *camera);

#endif
