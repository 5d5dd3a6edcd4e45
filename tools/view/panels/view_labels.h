/* Labels of contours: the heights of some of the wider lines, where the picture shows them.
 * Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_PANELS_VIEW_LABELS_H
#define STP_TOOLS_VIEW_PANELS_VIEW_LABELS_H

#include "runtime/stipple.h"

#define VIEW_LABELS_LIMIT 16

typedef struct view_label {
    stp_dvec3 place; /* in the model */
    double height;   /* of the line */
    double x, y;     /* where it was found, in the picture */
} view_label;

/* Zero is none. */
typedef struct view_labels {
    view_label items[VIEW_LABELS_LIMIT];
    int count;
    double step, base; /* of the contours that the labels are for */
    bool fresh;        /* they belong to the picture that is shown */
} view_labels;

/* Finds labels in the renderer's last picture: along rows and columns, where the surface crosses
 * the height of a wider line, far enough from each other (unscaled pixels times scale). None
 * without contours. Errors: those of reading depths and picking, OUT_OF_MEMORY. */
stp_status view_labels_find(view_labels *labels, stp_renderer *renderer, const stp_view *view,
                            const stp_draw_params *params, double scale, stp_error *err);

#endif
