/* What the GPU's own clock says of the stages of a frame that is timed: timestamps before and after
 * each, and a wait between stages, so that none runs into the next. Frames that are not timed have
 * no clock (NULL), and nothing is asked of the driver for them. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_STAGE_CLOCK_H
#define STP_RUNTIME_DRAW_STAGE_CLOCK_H

#include "runtime/stipple.h"

#include <epoxy/gl.h>

/* Created by stp_stage_clock_create. */
typedef struct stp_stage_clock {
    GLuint stamps[2]; /* timestamp queries: begin, end of the stage that runs */
    bool software;    /* the driver draws on the CPU */
    double *ms;       /* borrowed, by stage: where times are added */
} stp_stage_clock;

/* software: of stp_road_is_software. */
void stp_stage_clock_create(stp_stage_clock *clock, bool software);
void stp_stage_clock_destroy(stp_stage_clock *clock);

/* A stage begins; one that has begun is forgotten. clock may be NULL here and below. */
void stp_stage_begin(stp_stage_clock *clock);
/* What was asked for since then was this stage; waits for it, adds its time, and begins the next.
 */
void stp_stage_end(stp_stage_clock *clock, stp_stage stage);

#endif
