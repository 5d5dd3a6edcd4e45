/* Flying and walking: pressed keys move the camera over time. Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_MOVE_H
#define STP_TOOLS_VIEW_VIEW_MOVE_H

#include "tools/view/view_control.h"

/* Bits of view_control.held. */
enum {
    VIEW_HELD_FORWARD = 1u << 0,
    VIEW_HELD_BACK = 1u << 1,
    VIEW_HELD_LEFT = 1u << 2,
    VIEW_HELD_RIGHT = 1u << 3,
    VIEW_HELD_UP = 1u << 4,
    VIEW_HELD_DOWN = 1u << 5,
    VIEW_HELD_FAST = 1u << 6
};

/* Limits of the speed, as fractions of the scene's radius per second. */
#define VIEW_SPEED_LEAST 1e-4
#define VIEW_SPEED_MOST 10.0

/* Handles a key's press or release. False if the key does not move. */
bool view_move_key(view_control *control, const stp_window_event *event);
/* Changes the speed by notches of the wheel. */
void view_move_speed(view_control *control, double notches);
/* Sets speed and eye height that fit the navigation and the scene's size. */
void view_move_reset(view_control *control);
/* Puts a camera that is high up, or beside the model, on the ground in the middle of the picture.
 * It looks level in the same direction. */
void view_move_land(view_control *control);
/* Moves by the pressed keys for this many seconds. True while the camera still moves. */
bool view_move_advance(view_control *control, double seconds);

#endif
