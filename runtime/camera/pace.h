/* The threshold that holds a frame rate: solved for from what frames cost, without swinging.
 *
 * Cost falls as the threshold rises, by how much depends on model and view; so each frame moves the
 * logarithm of the threshold by a share of what the cost is off. What takes longer for other
 * reasons now and then is told by the median of three frames. Threads: any (no shared state). */
#ifndef STP_RUNTIME_CAMERA_PACE_H
#define STP_RUNTIME_CAMERA_PACE_H

#include <stdbool.h>

/* Of a frame's time, what drawing is to take: the rest is for showing it. */
#define STP_PACE_SHARE 0.9
/* Coarser than this is no picture of the model any more. */
#define STP_PACE_THRESHOLD_MOST_PX 64.0

typedef struct stp_pace {
    double fps;          /* wanted; 0: none, the threshold is the asked one */
    double asked_px;     /* no finer than this while frames follow each other */
    double threshold_px; /* of the next frame */
    double slope;        /* by which the logarithm of the cost falls with that of the threshold */
    double last_ms, last_px; /* of the last frame that counted; 0: none yet */
    bool spiked;             /* the last frame was one that did not count */
    int slow_frames;         /* at the coarsest threshold, less those that were not slow */
} stp_pace;

/* fps > 0, asked_px > 0. */
stp_pace stp_pace_begin(double fps, double asked_px);

/* Takes what the last frame cost, drawn at threshold_px; sets that of the next one. */
void stp_pace_follow(stp_pace *pace, double frame_ms);

/* False where even the coarsest threshold is too slow: what is left costs no points. */
bool stp_pace_holds(const stp_pace *pace);

#endif
