/* What is drawn over the picture: pivot, clip box, measured lines, status line, help. Threads: the
 * main thread only. */
#ifndef STP_TOOLS_VIEW_PANELS_VIEW_MARKS_H
#define STP_TOOLS_VIEW_PANELS_VIEW_MARKS_H

#include "tools/view/view_app.h"

/* Draws the pivot, the clip box, the measured lines, the status line and the help. */
void view_marks_draw(viewer *v);
/* A press on a handle of the clip box takes the handle; later events move it. True if the clip box
 * used the event. */
bool view_clip_handle(viewer *v, const stp_window_event *event);
/* Switches the clip box on or off. An empty clip box becomes the scene's box. */
void view_clip_toggle(viewer *v);

#endif
