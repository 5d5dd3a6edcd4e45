/* What the viewer remembers from one time to the next: which panels are open
 * and the size of screenshots, in view.json of the
 * folder of states. Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_SETTINGS_H
#define STP_TOOLS_VIEW_VIEW_SETTINGS_H

#include "tools/view/view_app.h"

/* The defaults where nothing is remembered, or it cannot be read. */
void view_settings_load(viewer *v);
/* Leaves the file alone where nothing changed; a folder that cannot be written is no matter. */
void view_settings_save(const viewer *v);

#endif
