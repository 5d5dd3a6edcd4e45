/* A recorded path made even: without dead time at its ends, without the hitches of slow frames, and
 * with eased ends.
 *
 * The camera's way stays; only when it passes each place changes. The way's speed is averaged over
 * two seconds, with weights of a cosine bell, so a hitch of half a second is gone and a rest of
 * three seconds stays. The pace rises from rest at the beginning and falls to rest at the end.
 * Keyframes are even in time. Threads: any (pure function). */
#ifndef STP_TOOLS_VIEW_KEPT_VIEW_SMOOTH_H
#define STP_TOOLS_VIEW_KEPT_VIEW_SMOOTH_H

#include "runtime/camera/path.h"

/* What easing adds at either end, at most. */
#define VIEW_SMOOTH_EASE_S 0.3

/* *out has *out_count keyframes from time 0 on; free with free(). One keyframe, or a camera that
 * never moves, gives one keyframe. Errors: those of stp_path_create; OUT_OF_MEMORY. */
stp_status view_smooth(stp_keyframe **out, size_t *out_count, const stp_keyframe *frames,
                       size_t count, stp_error *err);

#endif
