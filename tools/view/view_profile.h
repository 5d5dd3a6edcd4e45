/* The profile along a measured line, computed and saved on a thread of its own, so that the viewer
 * goes on drawing.
 *
 * Threads: the main thread only. One job at a time. Memory: 48 bytes a point found. */
#ifndef STP_TOOLS_VIEW_VIEW_PROFILE_H
#define STP_TOOLS_VIEW_VIEW_PROFILE_H

#include "tools/profile/profile_cut.h"
#include "tools/view/kept/view_files.h"

#include <pthread.h>

/* A chart is so many cells wide and high, and shows at most so many of them. */
#define VIEW_PROFILE_COLUMNS 480
#define VIEW_PROFILE_ROWS 100
#define VIEW_PROFILE_CELLS 6000
#define VIEW_PROFILE_FILES 32

typedef enum view_profile_state {
    VIEW_PROFILE_NONE,
    VIEW_PROFILE_FINDING,
    VIEW_PROFILE_READY,
    VIEW_PROFILE_SAVING
} view_profile_state;

typedef struct view_profile_cell {
    uint16_t column, row; /* row 0 is the lowest */
    uint8_t rgb[3];
} view_profile_cell;

/* Zero is none. */
typedef struct view_profile {
    view_profile_state state; /* while FINDING or SAVING, view_profile_poll notices the end */
    profile found;
    double low, high; /* least and greatest height */
    view_profile_cell cells[VIEW_PROFILE_CELLS];
    size_t cell_count;
    /* the job */
    profile_line line;
    stp_chunk_file *files[VIEW_PROFILE_FILES]; /* borrowed */
    size_t file_count;
    char path[VIEW_PATH_BYTES]; /* of the file to write */
    bool chart;                 /* it is an SVG */
    pthread_t thread;
    pthread_mutex_t lock; /* guards done and cancelled; no other lock is taken while it is held */
    bool done, cancelled;
    stp_status status; /* of the job; like error, read only after joining the thread */
    stp_error error;
} view_profile;

/* Begins to find the points of all files along a line; replaces a profile that is ready. wake is
 * called from the thread when it ends. Errors: LIMIT (no thread, or a job is running). */
stp_status view_profile_begin(view_profile *p, stp_chunk_file *const *files, size_t count,
                              const profile_line *line, stp_error *err);
/* Begins to write the points as CSV or as a chart to a new file. Errors: as view_profile_begin. */
stp_status view_profile_save(view_profile *p, const char *path, bool chart, stp_error *err);
/* Whether a job has ended; its status then. Errors: those of the job. */
bool view_profile_poll(view_profile *p, stp_status *status, stp_error *err);
/* Ends a job that reads a file, or any job and the profile if file is NULL. Waits for the thread.
 */
void view_profile_forget(view_profile *p, const stp_chunk_file *file);

#endif
