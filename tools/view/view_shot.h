/* Makes a screenshot that may be larger than any framebuffer. The picture is drawn part by part;
 * each part has a rim as wide as the reconstruction reaches. Then a thread of its own writes the
 * file.
 *
 * Threads: the main thread, with the renderer's context. Memory: the whole picture. */
#ifndef STP_TOOLS_VIEW_VIEW_SHOT_H
#define STP_TOOLS_VIEW_VIEW_SHOT_H

#include "formats/image/image.h"
#include "runtime/stipple.h"
#include "tools/view/kept/view_files.h"

#include <pthread.h>

#define VIEW_SHOT_LIMIT 16384

/* Columns of a picture, from `begin` on and before `end`, and what draws them. */
typedef struct view_stripe {
    stp_renderer *renderer;
    stp_draw_params params;
    int begin, end;
} view_stripe;

typedef enum view_shot_state {
    VIEW_SHOT_NONE,
    VIEW_SHOT_DRAWING,
    VIEW_SHOT_WRITING,
    VIEW_SHOT_WRITTEN,
    VIEW_SHOT_FAILED
} view_shot_state;

/* Zero is none. */
typedef struct view_shot {
    view_shot_state state; /* while WRITING, view_shot_poll notices the end */
    stp_image image;
    uint8_t *part; /* pixels of one part with its rim */
    stp_view view; /* view of the whole picture */
    int next, count;
    char path[VIEW_PATH_BYTES];
    pthread_t writer;
    pthread_mutex_t lock; /* guards done; no other lock is taken while it is held */
    bool done;
    stp_status written; /* status of the writer; like error, read only after joining the thread */
    stp_error error;
} view_shot;

/* Begins a picture of this view, in the view's size. Errors: LIMIT (size), OUT_OF_MEMORY. */
stp_status view_shot_begin(view_shot *shot, const stp_view *view, const char *path, stp_error *err);
/* Draws one more part, with its cut complete. After the last part, writing begins. stripes: of the
 * whole picture; together they cover it. Errors: those of drawing; the shot is FAILED then. */
stp_status view_shot_draw(view_shot *shot, const view_stripe *stripes, int count, stp_error *err);
/* Checks whether writing has ended. Errors: those of stp_image_save. */
stp_status view_shot_poll(view_shot *shot, stp_error *err);
/* The part of drawing that is done, 0 to 1. */
double view_shot_done(const view_shot *shot);
/* Stops drawing, waits until writing ends, and frees everything. */
void view_shot_end(view_shot *shot);

#endif
