/* A screenshot larger than any framebuffer: drawn part by part, with a rim around each that the
 * reconstruction reaches over, then written by a thread of its own.
 *
 * Threads: the main thread, with the renderer's context. The picture is in memory as a whole. */
#ifndef STP_TOOLS_VIEW_VIEW_SHOT_H
#define STP_TOOLS_VIEW_VIEW_SHOT_H

#include "formats/image/image.h"
#include "runtime/stipple.h"
#include "tools/view/view_files.h"

#include <pthread.h>

#define VIEW_SHOT_LIMIT 16384

typedef enum view_shot_state {
    VIEW_SHOT_NONE,
    VIEW_SHOT_DRAWING,
    VIEW_SHOT_WRITING,
    VIEW_SHOT_WRITTEN,
    VIEW_SHOT_FAILED
} view_shot_state;

/* Zero is none. */
typedef struct view_shot {
    view_shot_state state; /* while WRITING, its end is told by view_shot_poll */
    stp_image image;
    uint8_t *part; /* of one part, with its rim */
    stp_view view; /* of the whole */
    int next, count;
    char path[VIEW_PATH_BYTES];
    pthread_t writer;
    pthread_mutex_t lock; /* guards done; nothing else is taken while it is held */
    bool done;
    stp_status written; /* of the writer, and error: read after it was joined */
    stp_error error;
} view_shot;

/* Begins a picture of this view, whose size is the picture's. Errors: LIMIT (size), OUT_OF_MEMORY.
 */
stp_status view_shot_begin(view_shot *shot, const stp_view *view, const char *path, stp_error *err);
/* Draws one more part, with its cut complete; after the last the writing begins. Errors: those of
 * drawing; the shot is FAILED then. */
stp_status view_shot_draw(view_shot *shot, stp_renderer *renderer, const stp_draw_params *params,
                          stp_error *err);
/* Notices the end of writing. Errors: those of stp_image_save. */
stp_status view_shot_poll(view_shot *shot, stp_error *err);
/* Of the drawing, 0 to 1. */
double view_shot_done(const view_shot *shot);
/* Gives up drawing, waits for writing, and frees. */
void view_shot_end(view_shot *shot);

#endif
