/* Panels and widgets over a picture, by Dear ImGui.
 *
 * Draws with OpenGL into the bound framebuffer. Opens no window and asks no window for events: the
 * caller passes in what the user did. Lengths are pixels of the framebuffer, x right, y DOWN from
 * the top row. `scale` is the number of these pixels in one pixel of an ordinary screen; text is
 * made in that scale.
 * Call widgets between stp_ui_begin and stp_ui_end; they appear in that order, top to bottom. A
 * widget that edits a value returns true if the user changed the value. Labels must be unique in a
 * panel; the part after "##" is not shown.
 * The library keeps no file and moves no panel. Errors: only stp_ui_create can fail. If memory runs
 * out later, nothing more is drawn and stp_ui_is_exhausted returns true. Threads: the thread of the
 * GL context; one stp_ui per process (ImGui's state is global). */
#ifndef STP_RUNTIME_WINDOW_IMGUI_SHIM_H
#define STP_RUNTIME_WINDOW_IMGUI_SHIM_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stp_ui stp_ui;

/* How ImGui reads and writes the clipboard that other programs share; both may be NULL. */
typedef struct stp_ui_clipboard {
    const char *(*get)(void *context);
    void (*set)(void *context, const char *text);
    void *context;
} stp_ui_clipboard;

/* Errors: GL (ImGui cannot draw), OUT_OF_MEMORY. A GL context must be current from here to
 * destroy. */
stp_status stp_ui_create(stp_ui **out, double scale, const stp_ui_clipboard *clipboard,
                         stp_error *err);
void stp_ui_destroy(stp_ui **ui);
/* Whether memory ran out. From then on every call except destroy does nothing. */
bool stp_ui_is_exhausted(void);
/* Sets the scale of the screen that the window is on; cheap if unchanged. Not within a frame. */
void stp_ui_set_scale(stp_ui *ui, double scale);
double stp_ui_scale(const stp_ui *ui);

/* ---- input: pass in what the user does, as it comes, between frames ---- */

typedef enum stp_ui_key {
    STP_UI_KEY_TAB,
    STP_UI_KEY_LEFT,
    STP_UI_KEY_RIGHT,
    STP_UI_KEY_UP,
    STP_UI_KEY_DOWN,
    STP_UI_KEY_HOME,
    STP_UI_KEY_END,
    STP_UI_KEY_DELETE,
    STP_UI_KEY_BACKSPACE,
    STP_UI_KEY_ENTER,
    STP_UI_KEY_ESCAPE,
    STP_UI_KEY_A,
    STP_UI_KEY_C,
    STP_UI_KEY_V,
    STP_UI_KEY_X,
    STP_UI_KEY_Y,
    STP_UI_KEY_Z,
    STP_UI_KEY_COUNT
} stp_ui_key;

void stp_ui_pointer(stp_ui *ui, double x, double y);
void stp_ui_button_down(stp_ui *ui, int button, bool down); /* 0 left, 1 right, 2 middle */
void stp_ui_wheel(stp_ui *ui, double notches);
void stp_ui_key_down(stp_ui *ui, stp_ui_key key, bool down, bool shift, bool control);
void stp_ui_character(stp_ui *ui, uint32_t character);
/* Releases all keys and buttons that are held, since the window lost them. */
void stp_ui_release_all(stp_ui *ui);
/* Whether the pointer is over a panel; whether keys go to a text that is being edited. */
bool stp_ui_wants_pointer(stp_ui *ui);
bool stp_ui_wants_keys(const stp_ui *ui);

/* ---- a frame ---- */

void stp_ui_begin(stp_ui *ui, int width, int height, double seconds_since_last);
/* Draws the panels; leaves the GL state as it was. */
void stp_ui_end(stp_ui *ui);

/* ---- panels: call begin and end in pairs; call end even if begin returned false ---- */

typedef struct stp_ui_rect {
    double x, y, width, height; /* height 0: as high as the contents */
} stp_ui_rect;

bool stp_ui_panel_begin(const char *name, const stp_ui_rect *rect);
/* A panel above others, with a title and a cross. Pressing the cross sets *open to false. */
bool stp_ui_dialog_begin(const char *title, const stp_ui_rect *rect, bool *open);
void stp_ui_panel_end(void);
/* A heading that opens and closes the part below; the caller keeps *open. Returns *open. */
bool stp_ui_section(const char *title, bool *open);

/* ---- widgets ---- */

void stp_ui_text(const char *text);
void stp_ui_note(const char *text); /* dimmed and wrapped */
/* The value has a column of its own, in which lines break only at blanks. */
void stp_ui_row(const char *label, const char *value);
void stp_ui_swatch(const uint8_t rgb[3]);
bool stp_ui_button(const char *label);
bool stp_ui_check(const char *label, bool *value);
/* One of "a|b|c". A word is not offered if its bit in `allowed` is 0. */
bool stp_ui_choice(const char *label, int *value, const char *words, uint32_t allowed);
/* The same as a row of buttons. */
bool stp_ui_radio(int *value, const char *words, uint32_t allowed);
bool stp_ui_slider(const char *label, double *value, double low, double high, const char *format,
                   bool logarithmic);
/* Typed numbers, taken when the user presses Enter or leaves the field. */
bool stp_ui_number(const char *label, double *value, const char *format);
bool stp_ui_numbers(const char *label, double values[3], const char *format);
bool stp_ui_field(const char *label, char *text, size_t bytes);
/* The next widget gets the keyboard. */
void stp_ui_focus_next(void);
/* A text as wide as the panel. True if the user pressed Enter in it. */
bool stp_ui_line(const char *label, char *text, size_t bytes);
/* A line of a list. True if the user pressed on it. */
bool stp_ui_item(const char *text, bool chosen);
/* A chart of a ring of values that begins at index `first`; the axis goes from 0 to `top`. */
void stp_ui_chart(const char *text, const float *values, int count, int first, float top);
void stp_ui_same_line(void);
void stp_ui_space(void);
void stp_ui_hint(const char *text); /* shown while the pointer rests on the last widget */
void stp_ui_push_id(int id);
void stp_ui_pop_id(void);
void stp_ui_disable_begin(bool disabled);
void stp_ui_disable_end(void);

#ifdef __cplusplus
}
#endif

#endif
