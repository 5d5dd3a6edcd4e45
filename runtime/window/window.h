/* A window with an OpenGL 4.5 core context, and the user's input.
 *
 * Opens, waits for events and shows pictures; decides nothing about what is drawn.
 * Lengths are pixels of the window's framebuffer, y up, as in the picture on screens of any scale.
 * The size is 0 x 0 while the window is minimised.
 * Threads: the main thread only; one window per process. The context is current from create to
 * destroy. */
#ifndef STP_RUNTIME_WINDOW_WINDOW_H
#define STP_RUNTIME_WINDOW_WINDOW_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum stp_window_event_kind {
    STP_WINDOW_CHARACTER, /* a typed character, without Ctrl and Alt: character */
    STP_WINDOW_KEY,       /* key, down, repeated, shift, control */
    STP_WINDOW_PRESS,     /* a mouse button: button, x, y, shift, control */
    STP_WINDOW_RELEASE,   /* the same members */
    STP_WINDOW_MOVE,      /* the cursor: x, y; consecutive moves in the queue are merged */
    STP_WINDOW_WHEEL,     /* x, y, wheel */
    STP_WINDOW_DROP,      /* files were dropped: stp_window_dropped has their names */
    STP_WINDOW_REFRESH,   /* the size or the scale changed or the picture was lost */
    STP_WINDOW_BLUR,      /* the keyboard focus is lost: held keys report no release */
    STP_WINDOW_CLOSE      /* the user closed the window; it stays until destroyed */
} stp_window_event_kind;

typedef enum stp_window_button {
    STP_WINDOW_LEFT = 0,
    STP_WINDOW_RIGHT = 1,
    STP_WINDOW_MIDDLE = 2
} stp_window_button;

/* Keys by their place on a US keyboard. Letters and digits are 'A' to 'Z' and '0' to '9'. */
typedef enum stp_window_key {
    STP_KEY_NONE = 0,
    STP_KEY_SPACE = ' ',
    STP_KEY_ESCAPE = 256,
    STP_KEY_ENTER,
    STP_KEY_TAB,
    STP_KEY_BACKSPACE,
    STP_KEY_DELETE,
    STP_KEY_LEFT,
    STP_KEY_RIGHT,
    STP_KEY_UP,
    STP_KEY_DOWN,
    STP_KEY_PAGE_UP,
    STP_KEY_PAGE_DOWN,
    STP_KEY_HOME,
    STP_KEY_END,
    STP_KEY_SHIFT, /* left or right */
    STP_KEY_F1,
    STP_KEY_F11,
    STP_KEY_COUNT
} stp_window_key;

typedef struct stp_window_event {
    stp_window_event_kind kind;
    uint32_t character; /* Unicode */
    int key;            /* stp_window_key */
    int button;         /* stp_window_button, or a higher number */
    bool down, repeated;
    bool shift, control;
    double x, y;
    double wheel; /* notches away from the user */
    double at_s;  /* when the event was noticed, in seconds since the window opened */
} stp_window_event;

/* The queue holds so many events; further events are lost. */
#define STP_WINDOW_EVENTS_LIMIT 256
/* A drop brings so many file names; further names are lost. */
#define STP_WINDOW_DROP_LIMIT 64

typedef struct stp_window stp_window;

/* Errors: GL (no display, or its OpenGL is too old; the message says which), OUT_OF_MEMORY.
 * fit: make the window smaller if it does not fit the screen; with size 0 x 0, take three quarters
 * of the screen's width and height. */
stp_status stp_window_create(stp_window **out, const char *title, int width, int height, bool fit,
                             stp_error *err);
void stp_window_destroy(stp_window **window);

/* Collects events. Waits at most so many seconds for the first one (0: does not wait). Events that
 * are not taken yet stay, and then there is no wait. */
void stp_window_wait(stp_window *window, double seconds);
/* Ends a wait of the main thread. Threads: any. */
void stp_window_wake(void);
/* Takes the next collected event; false if there is none. */
bool stp_window_next(stp_window *window, stp_window_event *out);
/* File name `index` of the last drop, or NULL past the last; valid until stp_window_wait. */
const char *stp_window_dropped(const stp_window *window, size_t index);

/* The clock of stp_window_event.at_s. */
double stp_window_seconds(const stp_window *window);

/* The size of the framebuffer. */
void stp_window_size(const stp_window *window, int *width, int *height);
/* Framebuffer pixels per pixel of an ordinary screen: 2 on many high-resolution screens. */
double stp_window_scale(const stp_window *window);
void stp_window_set_title(stp_window *window, const char *title);
/* Fills the window's screen, or returns the window to its place. */
void stp_window_set_full_screen(stp_window *window, bool full);
bool stp_window_is_full_screen(const stp_window *window);
/* Puts text on the clipboard. */
void stp_window_copy_text(stp_window *window, const char *text);
/* The text on the clipboard, or "". Valid until the next call. */
const char *stp_window_pasted_text(stp_window *window);
/* Shows the contents of framebuffer 0. */
void stp_window_present(stp_window *window);

#endif
