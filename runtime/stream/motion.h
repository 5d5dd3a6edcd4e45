/* Where a moving camera will be: what comes into sight soon is fetched before it does.
 * Threads: one at a time. */
#ifndef STP_RUNTIME_STREAM_MOTION_H
#define STP_RUNTIME_STREAM_MOTION_H

#include "runtime/camera/camera.h"

/* How far ahead. */
#define STP_MOTION_AHEAD_S 0.5
/* A longer pause between two views is a jump. */
#define STP_MOTION_PAUSE_S 1.0

/* Zero has seen no view yet. */
typedef struct stp_motion {
    stp_view last;
    double last_s;
    bool known;
} stp_motion;

/* Takes the view of a frame at a time in seconds. True if the camera moves; then *ahead is the view
 * it would have STP_MOTION_AHEAD_S later, were it to go on like that. */
bool stp_motion_follow(stp_motion *motion, const stp_view *view, double time_s, stp_view *ahead);

/* Whether two views see the same. */
bool stp_view_equal(const stp_view *a, const stp_view *b);

#endif
