/* Finds the files for what the user makes in the viewer. Pictures and paths go to the working
 * folder. What belongs to a model goes beside it or, if nothing can be written there, to the state
 * folder ($XDG_STATE_HOME/stipple, else ~/.local/state/stipple). Threads: any. */
#ifndef STP_TOOLS_VIEW_KEPT_VIEW_FILES_H
#define STP_TOOLS_VIEW_KEPT_VIEW_FILES_H

#include "base/json.h"

#define VIEW_PATH_BYTES 4096

/* The last part of a path or address: "b.stipple" of "a/b.stipple". If that part is "", the whole
 * path. */
const char *view_files_base(const char *path);
/* Finds the first name like "model-1.png" in the working folder that no file has. model: its name;
 * the ending is left out. Errors: EXISTS (all are taken). */
stp_status view_files_free(char out[VIEW_PATH_BYTES], const char *model, const char *ending,
                           stp_error *err);
/* Makes the path of a file in the state folder, which may not exist yet. Errors: IO (no home),
 * LIMIT (too long). */
stp_status view_files_state(char out[VIEW_PATH_BYTES], const char *name, stp_error *err);
/* Finds the file with what the user kept of a model: in the state folder, where it is newer, as it
 * could not be written beside the model, or beside the model. Errors: LIMIT (too long). */
stp_status view_files_find(char out[VIEW_PATH_BYTES], bool *found, const char *model,
                           const char *ending, stp_error *err);
/* Writes what the user kept of a model to `path` or, if that is "" or cannot be written, beside the
 * model or else to the state folder; path then says where. make: makes the JSON of `context`.
 * Errors: IO, LIMIT, OUT_OF_MEMORY. */
stp_status view_files_save(char path[VIEW_PATH_BYTES], const char *model, const char *ending,
                           cJSON *(*make)(const void *), const void *context, stp_error *err);
/* Makes all folders of a path. Errors: IO. */
stp_status view_files_make_folders(const char *path, stp_error *err);

#endif
