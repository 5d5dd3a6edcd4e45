/* Times the stages of a frame by the GPU's own clock: a timestamp before and after each stage, and
 * a wait between stages, so that no stage overlaps the next. Frames that are not timed have no
 * clock (NULL) and ask nothing of the driver. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_STAGE_CLOCK_H
#define STP_RUNTIME_DRAW_STAGE_CLOCK_H

#include "runtime/stipple.h"

#include <epoxy/gl.h>

/* Set up by stp_stage_clock_create. */
typedef struct stp_stage_clock {
    GLuint stamps[2]; /* timestamp queries: begin, end of the running stage */
    bool software;    /* the driver draws on the CPU */
    double *ms;       /* borrowed: times are added here, by stage */
} stp_stage_clock;

/* software: from stp_road_is_software. */
void stp_stage_clock_create(stp_stage_clock *clock, bool software);
void stp_stage_clock_destroy(stp_stage_clock *clock);

/* Begins a stage; a stage begun before is forgotten. clock may be NULL here and below. */
void stp_stage_begin(stp_stage_clock *clock);
/* Ends the stage begun last as `stage`: waits for its GPU commands, adds its time, and begins the
 * next stage. */
void stp_stage_end(stp_stage_clock *clock, stp_stage stage);

#endif
