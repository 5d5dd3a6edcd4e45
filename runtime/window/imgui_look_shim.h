/* The panels' font and colours, for a screen of some scale; a part of imgui_shim.cpp.
 *
 * ImGui's context is there. Threads: as imgui_shim.h. */
#ifndef STP_RUNTIME_WINDOW_IMGUI_LOOK_SHIM_H
#define STP_RUNTIME_WINDOW_IMGUI_LOOK_SHIM_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* False if there is no memory. */
bool stp_ui_look_set(double scale);

#ifdef __cplusplus
}
#endif

#endif
