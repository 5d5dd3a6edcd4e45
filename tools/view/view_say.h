/* Says things in the status line, and writes places and lengths as text. Threads: the main thread
 * only. */
#ifndef STP_TOOLS_VIEW_VIEW_SAY_H
#define STP_TOOLS_VIEW_VIEW_SAY_H

#include "tools/view/view_app.h"

/* Says something in the status line for some seconds. */
void view_note(viewer *v, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Formats "456123.250  5428001.125  310.500", with as many digits as the scene's size needs. */
void view_format_position(const viewer *v, stp_dvec3 position, char out[160]);
int view_digits(const viewer *v);
/* Adds a unit to a number: "23.125 m". Nothing if it is not known. */
void view_add_unit(const viewer *v, view_unit of, char *text, size_t bytes);
/* Formats a length with as many digits as view_digits says, and its unit. */
void view_format_length(const viewer *v, double length, view_unit of, char out[96]);
/* Formats "412.3 m": a height. */
void view_format_height(const viewer *v, double height, char out[96]);
/* Gets the window position, y down, of a place in the model. False if it is behind the eye. */
bool view_place(const viewer *v, stp_dvec3 place, double at[2]);
/* The same of a place in the world as drawn. */
bool view_place_drawn(const viewer *v, stp_dvec3 place, double at[2]);

#endif
