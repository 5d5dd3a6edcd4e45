/* Fulfils what the user wishes: start view, records, screenshots, kept views, models.
 * Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_WISHES_H
#define STP_TOOLS_VIEW_VIEW_WISHES_H

#include "tools/view/view_app.h"

/* Updates the places of the picture and the panel from the window's size. */
void view_layout_update(viewer *v);
/* Goes to the start view, for the picture's present size. Errors: those of draw_options_camera. */
stp_status view_go_home(viewer *v, stp_error *err);
/* Fulfils the wishes in control.wants. Errors: those that end the viewer. */
stp_status view_fulfil(viewer *v, stp_error *err);
/* Begin or end recording; begin a screenshot; keep a view. Each shows a note. */
void view_toggle_record(viewer *v);
void view_begin_shot(viewer *v);
void view_keep(viewer *v);
void view_save_bookmarks(viewer *v);
void view_recall(viewer *v, size_t index);
/* Removes a model. The last one stays. */
void view_remove_model(viewer *v, size_t index);
/* Gives the scene's models to the renderer; the first call creates the renderer. Errors: those of
 * creating it; then it draws the models of before. */
stp_status view_scene_changed(viewer *v, stp_error *err);
/* Draws heights so many times as high, about the scene's middle; what the camera looks at stays. */
void view_exaggerate(viewer *v, double times);
/* Sets the ball that views are made with, after the scene or its heights changed. */
void view_ball_changed(viewer *v);

#endif
