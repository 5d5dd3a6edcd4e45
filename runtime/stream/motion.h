/* Predicts where a moving camera will be, so that blocks are fetched before they come into sight.
 * Threads: one at a time. */
#ifndef STP_RUNTIME_STREAM_MOTION_H
#define STP_RUNTIME_STREAM_MOTION_H

#include "runtime/camera/camera.h"

/* How far to look ahead. */
#define STP_MOTION_AHEAD_S 0.5
/* After a longer pause between two views, the new view is a jump. */
#define STP_MOTION_PAUSE_S 1.0

/* Zero has seen no view yet. */
typedef struct stp_motion {
    stp_view last;
    double last_s;
    bool known;
} stp_motion;

/* Takes the view of a frame at a time in seconds. Returns true if the camera moves; then *ahead is
 * the view after STP_MOTION_AHEAD_S more of the same motion. */
bool stp_motion_follow(stp_motion *motion, const stp_view *view, double time_s, stp_view *ahead);

/* Whether two views show the same. */
bool stp_view_equal(const stp_view *a, const stp_view *b);

#endif
