/* The colour bar of elevation and intensity. Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_PANELS_VIEW_LEGEND_H
#define STP_TOOLS_VIEW_PANELS_VIEW_LEGEND_H

#include "tools/view/view_app.h"

/* Formats an intensity from 0 to 1 in the scans' own numbers, rounded as far as it is known, or in
 * per cent if they are not known. top: view_scene.intensity_top. */
void view_format_intensity(double top, double intensity, char out[64]);
/* Draws the colour bar of elevation and intensity at the left end of a picture; nothing if other
 * colours are shown. */
void view_legend_draw(const viewer *v, double left);

#endif
