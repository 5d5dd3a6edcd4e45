/* Places in a model that the user marked, in a file given or in M.stipple.marks.json beside the
 * model:
 * {"marks": [{"name": "..", "position": [x, y, z]}, ...]}, in the scan's coordinates.
 *
 * Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_KEPT_VIEW_MARKED_H
#define STP_TOOLS_VIEW_KEPT_VIEW_MARKED_H

#include "tools/view/kept/view_files.h"

#include <stddef.h>

#define VIEW_MARKED_LIMIT 256
#define VIEW_MARK_BYTES 64

typedef struct view_mark {
    char name[VIEW_MARK_BYTES];
    stp_dvec3 position;
} view_mark;

/* Zero is none. */
typedef struct view_marked {
    view_mark items[VIEW_MARKED_LIMIT];
    size_t count;
    char path[VIEW_PATH_BYTES]; /* file that they were read from or written to; "" before */
    bool given;                 /* the user gave that file: they go nowhere else */
} view_marked;

/* Reads the marks of a file, or if that is NULL of the model. A missing file is no error: it is
 * made with the first mark. Errors: FORMAT (names the mark), IO, LIMIT. */
stp_status view_marked_load(view_marked *marked, const char *file, const char *model,
                            stp_error *err);
/* Writes all marks; path says where. Errors: IO. */
stp_status view_marked_save(view_marked *marked, const char *model, stp_error *err);
/* Appends a mark, named after its number. False if there are VIEW_MARKED_LIMIT marks. */
bool view_marked_add(view_marked *marked, stp_dvec3 position);
void view_marked_remove(view_marked *marked, size_t index);

#endif
