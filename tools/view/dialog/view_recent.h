/* The files that the viewer opened last, the newest first: recent.json in the state folder.
 *
 * If that file cannot be read or written, nothing is remembered, and nobody is told. Threads: any.
 */
#ifndef STP_TOOLS_VIEW_DIALOG_VIEW_RECENT_H
#define STP_TOOLS_VIEW_DIALOG_VIEW_RECENT_H

#include <stddef.h>

#define VIEW_RECENT_LIMIT 10

/* Whole paths and addresses, owned. Zero is empty. */
typedef struct view_recent {
    char *paths[VIEW_RECENT_LIMIT];
    size_t count;
} view_recent;

void view_recent_load(view_recent *out);
/* Puts a path first and saves the list. Addresses that may hold secrets are left out. */
void view_recent_note(const char *path);
void view_recent_clear(view_recent *recent);

#endif
