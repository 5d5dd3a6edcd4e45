/* Which palette a picture uses, and the values at the palette's two ends.
 * Threads: any (the model is read-only). */
#ifndef STP_RUNTIME_COLOUR_RANGE_H
#define STP_RUNTIME_COLOUR_RANGE_H

#include "runtime/stipple.h"

/* The palette to use: OWN is resolved, so never OWN. */
stp_palette stp_colour_palette(const stp_draw_params *params);
/* The red, green, blue of a value clamped to 0..1, each 0 to 1: stp_palette_ramp of
 * shaders/shade/palette.glsl; a test compares the two. palette: not OWN. */
void stp_palette_colour(stp_palette palette, double value, float rgb[3]);
/* The 2nd and 98th percentile of values, which it sorts; 0 and 0 of none. */
void stp_colour_range_of(double *values, uint32_t count, double range[2]);
/* Fills `out` with the range in the form that shaders read. */
void stp_colour_range_place(float out[4], const stp_draw_params *params, const stp_dvec3 *eye);

/* stp_model_colour_range without another share of the values at either end, from 0 to 0.5. */
stp_status stp_model_colour_part(const stp_model *model, stp_colour colour, double share,
                                 double range[2], stp_error *err);

#endif
