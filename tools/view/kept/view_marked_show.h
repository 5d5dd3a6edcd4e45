/* Marks that the user puts on the surface: pins in the picture, and their panel. Threads: the main
 * thread only. */
#ifndef STP_TOOLS_VIEW_KEPT_VIEW_MARKED_SHOW_H
#define STP_TOOLS_VIEW_KEPT_VIEW_MARKED_SHOW_H

#include "tools/view/view_app.h"

/* Marks what is under the cursor. */
void view_mark_here(viewer *v);
/* Draws a pin for each mark; dim if the surface hides it. */
void view_marked_draw(viewer *v);

#endif
