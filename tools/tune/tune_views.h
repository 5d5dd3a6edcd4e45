/* The views and short camera moves over which thresholds are measured.
 *
 * By default the views are directions of the 26 from which a cube's faces, edges and corners are
 * seen, each at one of three distances: the whole model fills the picture, and 1/3 and 1/9 of the
 * way to the surface in the middle of that picture. The first 78 are all of them; the first few are
 * a good mixture. Threads: the render thread. */
#ifndef STP_TOOLS_TUNE_TUNE_VIEWS_H
#define STP_TOOLS_TUNE_TUNE_VIEWS_H

#include "runtime/cut/model.h"
#include "runtime/stipple.h"

#define TUNE_VIEWS_LIMIT 78
#define TUNE_DOLLIES 3
#define TUNE_DOLLY_FRAMES 9
/* A dolly ends at this share of the distance at which it begins. */
#define TUNE_DOLLY_SHARE 0.9

typedef struct tune_view {
    stp_camera camera;
    char name[48];
} tune_view;

typedef struct tune_views {
    tune_view list[TUNE_VIEWS_LIMIT];
    stp_view views[TUNE_VIEWS_LIMIT];
    size_t count;
    stp_view dollies[TUNE_DOLLIES][TUNE_DOLLY_FRAMES];
    size_t dolly_count;
} tune_views;

typedef struct tune_views_params {
    const stp_model *model;
    stp_renderer *renderer; /* draws to find the surface */
    stp_draw_params drawn;
    const stp_camera *camera; /* the only view, or the start of a path; NULL: use directions */
    const char *path;         /* a path to take views along, or NULL */
    size_t count;             /* at most; views that show nothing are left out */
    int size[2];
} tune_views_params;

/* Errors: EMPTY (nothing is seen from anywhere), those of drawing and of reading the path. */
stp_status tune_views_create(tune_views *out, const tune_views_params *params, stp_error *err);

#endif
