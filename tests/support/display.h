/* A virtual display of a test's own (Xvfb), and the titles of the windows on it.
 *
 * One at a time; what display_start sets in the environment is for programs started later. Needs
 * Xvfb and xdotool. Threads: one. */
#ifndef STP_TESTS_SUPPORT_DISPLAY_H
#define STP_TESTS_SUPPORT_DISPLAY_H

#include <stdbool.h>

/* Sets DISPLAY. False, and says why, if there is none to be had. */
bool display_start(void);
void display_stop(void);
/* Whether a window is seen that has this in its title. The text has no quotes. */
bool display_has_title(const char *text);

#endif
