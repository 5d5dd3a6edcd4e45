/* Compares what two frames ask for. Threads: any. */
#ifndef STP_RUNTIME_DRAW_DRAW_PARAMS_H
#define STP_RUNTIME_DRAW_DRAW_PARAMS_H

#include "runtime/stipple.h"

/* Whether two frames of one view ask for the same picture. How fast they fade does not matter. */
bool stp_draw_params_equal(const stp_draw_params *a, const stp_draw_params *b);

#endif
