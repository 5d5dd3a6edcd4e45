/* Lines, dots and labels over the picture, under the panels of imgui_shim.h, by Dear ImGui.
 *
 * To be called between stp_ui_begin and stp_ui_end. Lengths are pixels of the framebuffer, x right,
 * y down; colours 0xRRGGBBAA. What cannot be drawn is left out. Threads: as imgui_shim.h. */
#ifndef STP_RUNTIME_WINDOW_IMGUI_MARKS_SHIM_H
#define STP_RUNTIME_WINDOW_IMGUI_MARKS_SHIM_H

#include "runtime/window/imgui_shim.h"

#ifdef __cplusplus
extern "C" {
#endif

void stp_ui_draw_line(double x0, double y0, double x1, double y1, uint32_t colour, double width);
void stp_ui_draw_circle(double x, double y, double radius, uint32_t colour, double width);
void stp_ui_draw_disc(double x, double y, double radius, uint32_t colour);
/* Text on a dark ground; (x, y) is its top left corner, or its middle. */
void stp_ui_draw_label(double x, double y, const char *text, uint32_t colour, bool centred);
/* What is drawn from here on stays within; pop undoes the last. */
void stp_ui_clip_push(const stp_ui_rect *rect);
void stp_ui_clip_pop(void);
double stp_ui_text_height(void);

#ifdef __cplusplus
}
#endif

#endif
