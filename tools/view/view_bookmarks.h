/* Views of a model that the user kept, in M.stipple.views.json beside it: {"views": [{"name": "..",
 * "eye": [x, y, z], ...}, ...]}, each a camera as runtime/camera/camera_json.h has it.
 *
 * Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_BOOKMARKS_H
#define STP_TOOLS_VIEW_VIEW_BOOKMARKS_H

#include "runtime/camera/camera.h"
#include "tools/view/view_files.h"

#include <stddef.h>

#define VIEW_BOOKMARKS_LIMIT 64
#define VIEW_BOOKMARK_BYTES 64

typedef struct view_bookmark {
    char name[VIEW_BOOKMARK_BYTES];
    stp_camera camera;
} view_bookmark;

/* Zero is none. */
typedef struct view_bookmarks {
    view_bookmark items[VIEW_BOOKMARKS_LIMIT];
    size_t count;
    char path[VIEW_PATH_BYTES]; /* of the file they came from or went to; "" so far */
} view_bookmarks;

/* Reads those of a model; no file is no error. Errors: FORMAT (names the key), IO, LIMIT. */
stp_status view_bookmarks_load(view_bookmarks *bookmarks, const char *model, stp_error *err);
/* Writes them all: beside the model, or, where that cannot be, in the folder of states; path says
 * where. Errors: IO. */
stp_status view_bookmarks_save(view_bookmarks *bookmarks, const char *model, stp_error *err);
/* Appends a view named after its number; false where there are VIEW_BOOKMARKS_LIMIT. */
bool view_bookmarks_add(view_bookmarks *bookmarks, const stp_camera *camera);
void view_bookmarks_remove(view_bookmarks *bookmarks, size_t index);

#endif
