/* Sets the panels' font and colours for a screen's scale; part of imgui_shim.cpp.
 *
 * Needs ImGui's context. Threads: as imgui_shim.h. */
#ifndef STP_RUNTIME_WINDOW_IMGUI_LOOK_SHIM_H
#define STP_RUNTIME_WINDOW_IMGUI_LOOK_SHIM_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* False if memory ran out. */
bool stp_ui_look_set(double scale);

#ifdef __cplusplus
}
#endif

#endif
