/* Adds models and scans to the viewer. It shows a coarse model of a scan at once, and the whole one
 * as soon as a child process has made it (view_prepare_child.h).
 *
 * One model is prepared at a time. The child begins when the coarse model is on the screen; when it
 * is done, its model takes the place of the coarse one, at the same camera. If it fails, the coarse
 * one stays, and a sentence says why. Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_PREPARE_VIEW_PREPARE_H
#define STP_TOOLS_VIEW_PREPARE_VIEW_PREPARE_H

#include "tools/view/view_app.h"

/* Adds the models of a command line to the scene, and all scans together as one model. If scans
 * were not prepared before, few points are prepared at once; of many, or if a window is open, a
 * coarse model is shown; without one, the model is added when it is done. Errors: those of
 * open_scan.h, open_draft.h and view_scene_add; LIMIT (another model is being prepared). */
stp_status view_prepare_add(viewer *v, const char *const *paths, size_t count, stp_error *err);
/* Whether a file or an address can be opened, as far as can be told at once: a model; a scan of up
 * to 64 MiB, since meshes are read whole; of a folder, the first scan. Errors: those of
 * open_scan_is, draw_options_open_model, prep_paths_add and stp_scan_open. */
stp_status view_prepare_check(const viewer *v, const char *path, stp_error *err);
/* Adds models and scans by name to a viewer that is open. Shows a note for each that cannot be
 * added. */
void view_add_models(viewer *v, const char *const *paths, size_t count);
/* Starts the child, takes what it says, and shows its model. Call it every turn. */
void view_prepare_turn(viewer *v);

#endif
