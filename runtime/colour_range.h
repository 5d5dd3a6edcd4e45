/* From what to what a palette goes.
 * Threads: any (the model is read-only). */
#ifndef STP_RUNTIME_COLOUR_RANGE_H
#define STP_RUNTIME_COLOUR_RANGE_H

#include "runtime/stipple.h"

/* The palette that is meant, never OWN. */
stp_palette stp_colour_palette(const stp_draw_params *params);
/* The range as shaders take it. */
void stp_colour_range_place(float out[4], const stp_draw_params *params, const stp_dvec3 *eye);

#endif
