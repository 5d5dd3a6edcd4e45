/* A picture while it is being drawn, and the order of its steps. Threads: the render thread. */
#ifndef STP_RUNTIME_FRAME_H
#define STP_RUNTIME_FRAME_H

#include "runtime/stipple.h"

/* Splats are drawn in two parts: the first finds the front of each pixel, the second adds up the
 * splats at the front. If the cut takes several passes, all passes of the first part run before the
 * second part begins. */
typedef enum stp_splat_part {
    STP_SPLAT_BOTH = 0,
    STP_SPLAT_FRONTS,
    STP_SPLAT_BLENDS
} stp_splat_part;

/* A picture while it is being drawn. */
typedef struct stp_drawing {
    const stp_view *view;
    const stp_draw_params *params;
    stp_draw_stats stats;
    bool waits;  /* waits for the GPU at the end */
    bool counts; /* counts by a query how many points the geometry shader emits */
    stp_splat_part part;
    bool ready;      /* stp_frame_ready is done */
    bool compiled;   /* and compiled programs */
    double ready_ms; /* what it took, unless blocks were on their way meanwhile */
} stp_drawing;

/* Draws one frame's picture. ahead: the view that the camera's motion leads to; may be NULL.
 * Errors: IO, GL, LIMIT, OUT_OF_MEMORY. */
stp_status stp_frame_draw(stp_renderer *r, stp_drawing *d, const stp_view *ahead, stp_error *err);

#endif
