/* Settings that the viewer remembers between runs: which panels are open and the size of
 * screenshots, in view.json of the state folder. Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_SETTINGS_H
#define STP_TOOLS_VIEW_VIEW_SETTINGS_H

#include "tools/view/view_app.h"

/* Loads the settings; the defaults if there are none or they cannot be read. */
void view_settings_load(viewer *v);
/* Saves the settings if they changed. Ignores a folder that cannot be written. */
void view_settings_save(const viewer *v);

#endif
