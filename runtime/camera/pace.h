/* Holds a frame rate: finds the threshold at which frames take the wanted time, without swinging.
 *
 * A higher threshold costs less; how much less depends on the model and the view. So each frame
 * moves log(threshold) by a share of the error in log(cost). A single frame that is far slower than
 * the last has another cause and does not count; a second slow frame counts. Threads: any (no
 * shared state). */
#ifndef STP_RUNTIME_CAMERA_PACE_H
#define STP_RUNTIME_CAMERA_PACE_H

#include <stdbool.h>

/* The share of a frame's time that drawing may take; the rest is for showing the frame. */
#define STP_PACE_SHARE 0.9
/* A coarser picture no longer shows the model. */
#define STP_PACE_THRESHOLD_MOST_PX 64.0

typedef struct stp_pace {
    double fps;              /* wanted; 0: none, threshold_px stays asked_px */
    double asked_px;         /* the finest threshold while frames follow each other */
    double threshold_px;     /* of the next frame */
    double slope;            /* log(cost) falls by this much per unit of log(threshold) */
    double last_ms, last_px; /* of the last frame that counted; 0: none yet */
    bool spiked;             /* the last frame did not count */
    int slow_frames;         /* slow frames at the coarsest threshold, minus those not slow */
} stp_pace;

/* fps > 0, asked_px > 0. */
stp_pace stp_pace_begin(double fps, double asked_px);

/* Takes the cost of the last frame, drawn at threshold_px, and sets threshold_px of the next. */
void stp_pace_follow(stp_pace *pace, double frame_ms);

/* False if even the coarsest threshold is too slow: the cost that is left is not one of points. */
bool stp_pace_holds(const stp_pace *pace);

#endif
