/* The child process that prepares scans for the viewer: stipple prep, told to report its progress.
 *
 * The child ends with the viewer and leaves nothing, since outputs appear whole. Threads: the main
 * thread only. */
#ifndef STP_TOOLS_VIEW_PREPARE_VIEW_PREPARE_CHILD_H
#define STP_TOOLS_VIEW_PREPARE_VIEW_PREPARE_CHILD_H

#include "tools/open/open_scan.h"

#include <sys/types.h>

#define VIEW_PREPARE_LINE 1200

typedef enum view_prepare_state {
    VIEW_PREPARE_NONE,
    VIEW_PREPARE_WAITING, /* until the coarse model is drawn */
    VIEW_PREPARE_RUNNING,
    VIEW_PREPARE_FAILED
} view_prepare_state;

/* Zero is none. */
typedef struct view_prepare {
    view_prepare_state state;
    open_scan scan;
    char **arguments; /* as given, owned */
    size_t count;
    pid_t process;
    int pipe;                     /* what the child says */
    char line[VIEW_PREPARE_LINE]; /* of it, not ended yet */
    size_t line_bytes;
    char why[VIEW_PREPARE_LINE]; /* the child's sentence if it failed; "" */
    double done, left_s;         /* share that is done; below 0: not known yet */
} view_prepare;

/* Starts the child; it then runs, or the state is FAILED. threads: as --threads, 0: all. */
void view_prepare_start(view_prepare *p, uint64_t threads);
/* Reads what the child said. False once it has ended: then call view_prepare_reap. */
bool view_prepare_listen(view_prepare *p);
/* Waits for its end; the state is then NONE. */
void view_prepare_reap(view_prepare *p);
/* Writes what the picture says of it. False if there is nothing to say. */
bool view_prepare_text(const view_prepare *p, char out[VIEW_PREPARE_LINE]);
/* Ends the child, if it runs, and frees everything. */
void view_prepare_end(view_prepare *p);

#endif
