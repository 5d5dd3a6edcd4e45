/* The panel at the side and its sections. Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_PANELS_VIEW_PANELS_H
#define STP_TOOLS_VIEW_PANELS_VIEW_PANELS_H

#include "tools/view/view_app.h"

void view_panels_draw(viewer *v);
void view_panel_models(viewer *v);
void view_panel_camera(viewer *v);
void view_panel_quality(viewer *v);
void view_panel_colour(viewer *v);
void view_panel_surface(viewer *v);
void view_panel_clip(viewer *v);
void view_panel_measure(viewer *v);
void view_panel_profile(viewer *v);
void view_panel_marks(viewer *v);
void view_panel_kept(viewer *v);
void view_panel_shot(viewer *v);
void view_panel_numbers(viewer *v);

#endif
