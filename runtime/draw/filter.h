/* Copies what a picture leaves out of a model or lays over it from the parameters to the frame:
 * clip box, hidden classes, overlay, eye-dome lighting. Threads: any (pure functions). */
#ifndef STP_RUNTIME_DRAW_FILTER_H
#define STP_RUNTIME_DRAW_FILTER_H

#include "runtime/gl/gpu_layout.h"
#include "runtime/stipple.h"

/* Errors: INVALID_ARGUMENT (a clip box that is inverted or not a number; overlay not in 0..1, edl
 * negative or not finite, fade not in 0..1 or 1). */
stp_status stp_filter_check(const stp_draw_params *params, stp_error *err);
/* Writes clip box, classes, overlay and eye-dome lighting. */
void stp_filter_place(stp_gpu_frame *frame, const stp_draw_params *params, const stp_dvec3 *eye);
/* Whether any class is hidden. */
bool stp_filter_hides_classes(const stp_draw_params *params);
/* Whether the shade's colours are mixed into the samples' colours. */
bool stp_filter_has_overlay(const stp_draw_params *params);

#endif
