/* Draws the scene if something changed, and panels and marks over it. Threads: the main thread
 * only. */
#ifndef STP_TOOLS_VIEW_VIEW_DRAW_H
#define STP_TOOLS_VIEW_VIEW_DRAW_H

#include "tools/view/view_app.h"

/* Draws the picture if it changed, and the panels if they changed. Errors: those of drawing. */
stp_status view_draw(viewer *v, stp_error *err);

#endif
