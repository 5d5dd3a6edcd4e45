/* The part of the picture that a box may cover. Threads: any (pure functions). */
#ifndef STP_RUNTIME_AREA_H
#define STP_RUNTIME_AREA_H

#include "runtime/model.h"
#include "runtime/reconstruct.h"

/* The rectangle around the root's box, which holds every disc, as the view sees it, with two pixels
 * to spare; the whole viewport where the box comes near the eye. */
stp_rectangle stp_model_area(const stp_model *model, const stp_view *view);

#endif
