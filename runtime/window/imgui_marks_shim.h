/* Draws lines, dots and labels over the picture, under the panels of imgui_shim.h, by Dear ImGui.
 *
 * Call these between stp_ui_begin and stp_ui_end. Lengths are pixels of the framebuffer, x right, y
 * down; colours are 0xRRGGBBAA. Marks that cannot be drawn are left out. Threads: as
 * imgui_shim.h. */
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
/* A dark red bar over the width of rect, at its top, with wrapped text. Returns the bar's height.
 */
double stp_ui_draw_bar(const stp_ui_rect *rect, const char *text);
/* Later marks are drawn within rect only, until stp_ui_clip_pop; pairs may nest. */
void stp_ui_clip_push(const stp_ui_rect *rect);
void stp_ui_clip_pop(void);
double stp_ui_text_height(void);

#ifdef __cplusplus
}
#endif

#endif
