/* Decides whether coordinates are a sensor's own, so that it stands at their origin, where a file
 * says nothing.
 *
 * - A depth camera looks along z or against it, or along x if z is up, and has a ray for each
 *   column and row: the points have few different x/z and y/z. Of a grid of heights x and y are
 *   few, too.
 * - A turning scanner on a vehicle or a robot has z up. Its rays go all around, none is steeper
 *   than 60 degrees, and a fiftieth of the points are five times as far as another fiftieth. These
 *   may be chance: seen_from.h must agree.
 *
 * Threads: any. */
#ifndef STP_PREPROCESS_VIEWPOINT_OWN_FRAME_H
#define STP_PREPROCESS_VIEWPOINT_OWN_FRAME_H

#include "base/error.h"
#include "base/vec.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum stp_own_frame {
    STP_OWN_FRAME_NONE,
    STP_OWN_FRAME_CAMERA,
    STP_OWN_FRAME_TURNING
} stp_own_frame;

/* Whether it is worth looking at more than these few points. */
bool stp_own_frame_may_be(const stp_dvec3 *few, uint32_t count);
/* positions: a sample of the points. Errors: OUT_OF_MEMORY. */
stp_status stp_own_frame_find(stp_own_frame *out, const stp_dvec3 *positions, uint32_t count,
                              stp_error *err);

#endif
