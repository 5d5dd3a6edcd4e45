/* The profile along the last measured line: its chart and its panel. Threads: the main thread only.
 */
#ifndef STP_TOOLS_VIEW_PANELS_VIEW_PROFILE_SHOW_H
#define STP_TOOLS_VIEW_PANELS_VIEW_PROFILE_SHOW_H

#include "tools/view/view_app.h"

/* Begins the profile of the last measured line. Shows a note. */
void view_profile_last(viewer *v);
/* Notices that a profile was made or saved. */
void view_profile_turn(viewer *v);
/* Closes the chart. False if none is shown. */
bool view_profile_close(viewer *v);
void view_profile_draw(const viewer *v);

#endif
