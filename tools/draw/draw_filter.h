/* Parses the texts of --clip, --classes and --hide-classes. Threads: any. */
#ifndef STP_TOOLS_DRAW_DRAW_FILTER_H
#define STP_TOOLS_DRAW_DRAW_FILTER_H

#include "runtime/stipple.h"

/* Parses "x0,y0,z0,x1,y1,z1" into *out. Errors: INVALID_ARGUMENT (not six finite numbers, an
 * inverted box, or a box that does not meet the model's box). */
stp_status draw_filter_clip(const char *text, const stp_dbox *model, stp_clip *out, stp_error *err);

/* Parses a list of class numbers and names into a bit set. `option` is the option's name for
 * messages. Errors: INVALID_ARGUMENT. */
stp_status draw_filter_classes(const char *option, const char *text, uint32_t out[8],
                               stp_error *err);

#endif
