/* The road of projection where none is asked for: the faster one on the driver at hand.
 *
 * A software driver runs compute shaders on all processors and geometry shaders on one, so it needs
 * no trial. Others begin with the geometry shader; pictures that stream, of which there are many a
 * second, then go by both roads in turns for TRIAL_FRAMES frames, timed by the GPU, and the faster
 * one stays. Pictures that wait for their chunks never try: two runs of a command draw the same.
 * The roads' pictures differ in ties of depth alone. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_ROAD_H
#define STP_RUNTIME_DRAW_ROAD_H

#include "runtime/stipple.h"

#include <epoxy/gl.h>
#include <stdbool.h>

enum { STP_ROAD_TRIAL_FRAMES = 16 }; /* of two roads; the first of each compiles its shaders */

/* Begun by stp_road_begin. */
typedef struct stp_road {
    stp_lod lod;                             /* what is taken where nothing is tried */
    bool decided;                            /* nothing is tried any more */
    bool tries;                              /* the frame in the making is one of the trial */
    int frame;                               /* frames of the trial that were drawn */
    GLuint stamps[STP_ROAD_TRIAL_FRAMES][2]; /* timestamp queries: begin, end */
} stp_road;

/* software: the driver draws on the CPU. */
void stp_road_begin(stp_road *road, bool software);
/* Whether the current context's driver does. */
bool stp_road_is_software(void);
/* The road of the frame that is to be drawn. streams: it does not wait for anything. */
stp_lod stp_road_take(stp_road *road, bool streams);
/* It was drawn. whole: it had all that it wanted, so that its time says something. */
void stp_road_leave(stp_road *road, bool whole);
/* Ends the trial; the road taken then stays. Its context is current. */
void stp_road_end(stp_road *road);

#endif
