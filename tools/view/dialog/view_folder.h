/* Lists a folder for the viewer's dialog: sub-folders, then chunk files, scans and grids of
 * heights, which it knows by the endings of their names. Both groups are sorted by name; hidden
 * files are left out. Threads: any. */
#ifndef STP_TOOLS_VIEW_DIALOG_VIEW_FOLDER_H
#define STP_TOOLS_VIEW_DIALOG_VIEW_FOLDER_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

/* More names are left out. */
#define VIEW_FOLDER_LIMIT 5000

/* Zero is empty. */
typedef struct view_folder {
    char **names; /* owned; sub-folders end with "/" */
    size_t count;
    bool is_cut; /* there are more */
} view_folder;

static inline bool view_folder_is_sub(const char *name)
{
    return name[strlen(name) - 1] == '/';
}

/* Replaces *folder. Errors: IO (the folder cannot be read), OUT_OF_MEMORY; *folder is empty then.
 */
stp_status view_folder_list(view_folder *folder, const char *path, stp_error *err);
void view_folder_clear(view_folder *folder);

#endif
