/* Views of a model that the user kept, in M.stipple.views.json beside the model: {"views":
 * [{"name": "..", "eye": [x, y, z], ...}, ...]}. Each is a camera as in
 * runtime/camera/camera_json.h.
 *
 * Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_KEPT_VIEW_BOOKMARKS_H
#define STP_TOOLS_VIEW_KEPT_VIEW_BOOKMARKS_H

#include "runtime/camera/camera.h"
#include "tools/view/kept/view_files.h"

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
    char path[VIEW_PATH_BYTES]; /* file that the views were read from or written to; "" before */
} view_bookmarks;

/* Reads the kept views of a model. A missing file is no error. Errors: FORMAT (names the key), IO,
 * LIMIT. */
stp_status view_bookmarks_load(view_bookmarks *bookmarks, const char *model, stp_error *err);
/* Writes all views beside the model or, if that is not possible, to the state folder. path says
 * where. Errors: IO. */
stp_status view_bookmarks_save(view_bookmarks *bookmarks, const char *model, stp_error *err);
/* Appends a view, named after its number. False if there are VIEW_BOOKMARKS_LIMIT views. */
bool view_bookmarks_add(view_bookmarks *bookmarks, const stp_camera *camera);
void view_bookmarks_remove(view_bookmarks *bookmarks, size_t index);

#endif
