/* Where the viewer keeps what the user makes: pictures and paths in the working folder, what
 * belongs to a model beside it, or, where that cannot be written, in the user's folder of states
 * ($XDG_STATE_HOME/stipple, else ~/.local/state/stipple). Threads: any. */
#ifndef STP_TOOLS_VIEW_VIEW_FILES_H
#define STP_TOOLS_VIEW_VIEW_FILES_H

#include "base/error.h"

#define VIEW_PATH_BYTES 4096

/* The last part of a path or address: "b.stipple" of "a/b.stipple"; the whole where that is "". */
const char *view_files_base(const char *path);
/* The first name like "model-1.png" in the working folder that no file has. model: its name, whose
 * ending is left out. Errors: EXISTS (they are all taken). */
stp_status view_files_free(char out[VIEW_PATH_BYTES], const char *model, const char *ending,
                           stp_error *err);
/* The name of a file in the folder of states, which need not be there. Errors: IO (no home), LIMIT
 * (too long). */
stp_status view_files_state(char out[VIEW_PATH_BYTES], const char *name, stp_error *err);
/* The same for what belongs to a model, by its path or address. Errors: likewise. */
stp_status view_files_model_state(char out[VIEW_PATH_BYTES], const char *model, const char *ending,
                                  stp_error *err);
/* Makes the folders that a path leads through. Errors: IO. */
stp_status view_files_make_folders(const char *path, stp_error *err);

#endif
