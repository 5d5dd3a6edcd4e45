/* A virtual display for a test (Xvfb), and the titles of its windows.
 *
 * One at a time. display_start sets the environment for programs that start later. Needs Xvfb and
 * xdotool. Threads: one. */
#ifndef STP_TESTS_SUPPORT_DISPLAY_H
#define STP_TESTS_SUPPORT_DISPLAY_H

#include <stdbool.h>

/* Sets DISPLAY. If there is no display, says why and returns false. */
bool display_start(void);
void display_stop(void);
/* Whether a visible window has this text in its title. The text may have no quotes. */
bool display_has_title(const char *text);

#endif
