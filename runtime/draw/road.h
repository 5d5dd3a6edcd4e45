/* Chooses the road of projection for STP_LOD_AUTO: the faster one on this driver.
 *
 * A software driver runs compute shaders on all processors and geometry shaders on one, so it needs
 * no trial: compute shaders. Other drivers begin with the geometry shader. If pictures stream, many
 * a second, they use both roads in turn for STP_ROAD_TRIAL_FRAMES frames, timed by the GPU, and the
 * faster road stays. Pictures that wait for their blocks never try, so two runs of a command draw
 * the same. The pictures of the roads differ only in ties of depth. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_ROAD_H
#define STP_RUNTIME_DRAW_ROAD_H

#include "runtime/stipple.h"

#include <epoxy/gl.h>
#include <stdbool.h>

enum { STP_ROAD_TRIAL_FRAMES = 16 }; /* of both roads; each road's first compiles its shaders */

/* Set up by stp_road_begin. */
typedef struct stp_road {
    stp_lod lod;                             /* the road outside the trial */
    bool decided;                            /* the trial has ended */
    bool tries;                              /* the current frame is part of the trial */
    int frame;                               /* number of trial frames drawn */
    GLuint stamps[STP_ROAD_TRIAL_FRAMES][2]; /* timestamp queries: begin, end */
} stp_road;

/* software: the driver draws on the CPU. */
void stp_road_begin(stp_road *road, bool software);
/* Whether the driver of the current context draws on the CPU. */
bool stp_road_is_software(void);
/* The road for the frame about to be drawn. streams: the frame waits for nothing. */
stp_lod stp_road_take(stp_road *road, bool streams);
/* Call after drawing the frame. whole: nothing was missing, so the frame's time counts. */
void stp_road_leave(stp_road *road, bool whole);
/* Ends the trial; the road at that time stays. The road's context must be current. */
/* Ends the trial; the road taken then stays. Its context is current. */
void stp_road_end(stp_road *road);

#endif
