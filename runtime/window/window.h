/* A window with an OpenGL 4.5 core context, and what the user does in it.
 *
 * Opens, waits for events, shows what was drawn; decides nothing of what is drawn.
 * Lengths are pixels of the window's framebuffer, y up, so that they fit the picture on screens of
 * any scale; the size is 0 x 0 while the window is minimised.
 * Threads: the main thread only; one window a process. The context is current from create to
 * destroy. */
#ifndef STP_RUNTIME_WINDOW_WINDOW_H
#define STP_RUNTIME_WINDOW_WINDOW_H

#include "base/error.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum stp_window_event_kind {
    STP_WINDOW_CHARACTER, /* a key that writes: character */
    STP_WINDOW_ESCAPE,
    STP_WINDOW_PRESS,   /* a mouse button: button, x, y, shift */
    STP_WINDOW_RELEASE, /* likewise */
    STP_WINDOW_MOVE,    /* the cursor: x, y; neighbours in the queue are joined */
    STP_WINDOW_WHEEL,   /* x, y, wheel */
    STP_WINDOW_REFRESH, /* the size changed or the picture was lost */
    STP_WINDOW_CLOSE    /* the user closed it; it stays until destroyed */
} stp_window_event_kind;

typedef enum stp_window_button {
    STP_WINDOW_LEFT = 0,
    STP_WINDOW_RIGHT = 1,
    STP_WINDOW_MIDDLE = 2
} stp_window_button;

typedef struct stp_window_event {
    stp_window_event_kind kind;
    uint32_t character; /* Unicode */
    int button;         /* stp_window_button, or a further one */
    bool shift;
    double x, y;
    double wheel; /* notches away from the user */
} stp_window_event;

/* Events between two waits; further ones are lost. */
#define STP_WINDOW_EVENTS_LIMIT 256

typedef struct stp_window stp_window;

/* Errors: GL (no display, or its OpenGL is too old: the sentence says which), OUT_OF_MEMORY.
 * fit: make it smaller where the screen is. */
stp_status stp_window_create(stp_window **out, const char *title, int width, int height, bool fit,
                             stp_error *err);
void stp_window_destroy(stp_window **window);

/* Collects events: waits for the first for at most so many seconds (0: does not wait). */
void stp_window_wait(stp_window *window, double seconds);
/* Takes the next collected event; false if there is none. */
bool stp_window_next(stp_window *window, stp_window_event *out);

/* Of the framebuffer. */
void stp_window_size(const stp_window *window, int *width, int *height);
void stp_window_set_title(stp_window *window, const char *title);
/* Shows what was drawn into framebuffer 0. */
void stp_window_present(stp_window *window);

#endif
