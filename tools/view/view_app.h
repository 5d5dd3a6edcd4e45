/* The viewer: what the files tools/view/view*.c share.
 *
 * One turn of the loop: events go to the panels or to view_control; view_wishes.c fulfils wishes;
 * the camera moves; view_draw.c draws the scene if something changed, and panels/ draws panels and
 * marks over it. Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_APP_H
#define STP_TOOLS_VIEW_VIEW_APP_H

#include "runtime/camera/pace.h"
#include "runtime/window/imgui_marks_shim.h"
#include "runtime/window/window.h"
#include "tools/draw/draw_options.h"
#include "tools/view/beside/view_beside.h"
#include "tools/view/dialog/view_open.h"
#include "tools/view/kept/view_bookmarks.h"
#include "tools/view/kept/view_marked.h"
#include "tools/view/kept/view_record.h"
#include "tools/view/view_control.h"
#include "tools/view/view_ground.h"
#include "tools/view/view_measure.h"
#include "tools/view/view_profile.h"
#include "tools/view/view_values.h"

#include <math.h>

/* Number of frames in the charts. */
#define VIEW_HISTORY 240
#define VIEW_NOTE_BYTES 1100
/* Panels are drawn this many times after an event, because they need some turns to settle. */
#define VIEW_TURNS_TO_SETTLE 3

/* Sections of the panel: X(name, function that draws it, title, open at first) */
#define VIEW_SECTION_LIST(X)                                                                       \
    X(BESIDE, view_panel_beside, "Two sides", true)                                                \
    X(MODELS, view_panel_models, "Models", true)                                                   \
    X(NUMBERS, view_panel_numbers, "Frames and memory", true)                                      \
    X(CAMERA, view_panel_camera, "Camera", true)                                                   \
    X(QUALITY, view_panel_quality, "Quality", true)                                                \
    X(COLOUR, view_panel_colour, "Colour", true)                                                   \
    X(SURFACE, view_panel_surface, "Surface and light", true)                                      \
    X(CLIP, view_panel_clip, "Clip box", false)                                                    \
    X(MEASURE, view_panel_measure, "Measure", false)                                               \
    X(PROFILE, view_panel_profile, "Profile", false)                                               \
    X(MARKS, view_panel_marks, "Marks", false)                                                     \
    X(KEPT, view_panel_kept, "Kept views and path", false)                                         \
    X(SHOT, view_panel_shot, "Screenshot", false)

typedef enum view_section {
#define X(name, draw, title, open) VIEW_SECTION_##name,
    VIEW_SECTION_LIST(X)
#undef X
        VIEW_SECTION_COUNT
} view_section;

/* A clip box that is dragged by one of its faces: 0 to 5, low x, high x, low y... -1: none. */
typedef struct view_clip {
    int face;
    double offset; /* place on the axis where the drag began, minus the face */
} view_clip;

typedef struct view_chart {
    float frame_ms[VIEW_HISTORY], points[VIEW_HISTORY];
    int next, count;
} view_chart;

/* The places of things in the window, in pixels. The picture is in its lower left corner. */
typedef struct view_layout {
    int width, height;                 /* of the window; 0: the window is not visible */
    int picture_width, picture_height; /* at least 1 */
    stp_ui_rect panel;                 /* y down */
} view_layout;

typedef struct viewer {
    union {
        struct {
            VIEW_SIDE_MEMBERS
        };
        view_side side;
    };
    view_beside beside; /* the other side */
    const cli_common *common;
    const char *marks_file; /* of --marks; NULL: beside the model */
    stp_window *window;
    stp_ui *ui;
    view_control control;
    stp_pick under; /* what is under the cursor */
    stp_pick clicked;
    view_values values; /* attributes of what was clicked, if the scene is one model */
    view_measure measure;
    view_clip clip;
    view_ground ground;
    view_bookmarks bookmarks;
    view_marked marked;
    int marks_hidden; /* pins in the picture that the surface hides */
    view_profile profile;
    view_record record;
    view_shot shot;
    int shot_size; /* index in VIEW_SHOT_SIZES */
    view_chart chart;
    view_layout layout;
    bool panels, help;
    bool panels_wanted; /* remembered; a narrow window shows none all the same */
    bool open[VIEW_SECTION_COUNT];
    int removing;               /* index of the model to remove after this turn; -1: none */
    char note[VIEW_NOTE_BYTES]; /* what just happened */
    double note_until_s;
    double now_s, last_turn_s, last_ui_s;
    int ui_turns;   /* how many more times to draw the panels, until they settle */
    double fps;     /* frame rate to hold while the camera moves; 0: no limit */
    stp_pace pace;  /* holds fps */
    double moved_s; /* when something changed last */
    stp_view drawn; /* of the last frame: control.view, perhaps with fewer pixels */
    bool loading;   /* chunks are on their way */
    bool resting;   /* nothing moves, but more frames come: finer ones */
    double last_frame_s;
    bool quits;
    uint64_t shader_state;
    view_open dialog;
    char next[VIEW_PATH_BYTES]; /* what to show instead, after this viewer quits; "": nothing */
} viewer;

#define VIEW_SHOT_SIZE_COUNT 6
#define VIEW_SHOT_SIZES "as the window|2 x|4 x|4096 px|8192 px|16384 px"

/* Whether the last frame has fewer pixels than the window shows. */
static inline bool view_is_small(const viewer *v)
{
    return v->drawn.width < v->control.view.width || v->drawn.height < v->control.view.height;
}

/* Takes a pixel of the window to the pixel of the last frame that is shown there. */
static inline void view_drawn_pixel(const viewer *v, int *x, int *y)
{
    *x = (int)floor((*x + 0.5) * v->drawn.width / v->layout.picture_width);
    *y = (int)floor((*y + 0.5) * v->drawn.height / v->layout.picture_height);
}

/* ---- view_say.c ---- */

/* Says something in the status line for some seconds. */
void view_note(viewer *v, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Formats "456123.250  5428001.125  310.500", with as many digits as the scene's size needs. */
void view_format_position(const viewer *v, stp_dvec3 position, char out[160]);
int view_digits(const viewer *v);
/* Adds a unit to a number: "23.125 m". Nothing if it is not known. */
void view_add_unit(const viewer *v, view_unit of, char *text, size_t bytes);
/* Formats a length with as many digits as view_digits says, and its unit. */
void view_format_length(const viewer *v, double length, view_unit of, char out[96]);
/* Formats "412.3 m": a height. */
void view_format_height(const viewer *v, double height, char out[96]);
/* Gets the window position, y down, of a place in the model. False if it is behind the eye. */
bool view_place(const viewer *v, stp_dvec3 place, double at[2]);
/* The same of a place in the world as drawn. */
bool view_place_drawn(const viewer *v, stp_dvec3 place, double at[2]);

/* ---- view_wishes.c ---- */

/* Updates the places of the picture and the panel from the window's size. */
void view_layout_update(viewer *v);
/* Goes to the start view, for the picture's present size. Errors: those of draw_options_camera. */
stp_status view_go_home(viewer *v, stp_error *err);
/* Fulfils the wishes in control.wants. Errors: those that end the viewer. */
stp_status view_fulfil(viewer *v, stp_error *err);
/* Begin or end recording; begin a screenshot; keep a view. Each shows a note. */
void view_toggle_record(viewer *v);
void view_begin_shot(viewer *v);
void view_keep(viewer *v);
void view_save_bookmarks(viewer *v);
void view_recall(viewer *v, size_t index);
/* Removes a model. The last one stays. */
void view_remove_model(viewer *v, size_t index);
/* Gives the scene's models to the renderer; the first call creates the renderer. Errors: those of
 * creating it; then it draws the models of before. */
stp_status view_scene_changed(viewer *v, stp_error *err);

/* Draws heights so many times as high, about the scene's middle; what the camera looks at stays. */
void view_exaggerate(viewer *v, double times);
/* Sets the ball that views are made with, after the scene or its heights changed. */
void view_ball_changed(viewer *v);

/* ---- kept/view_marked_show.c ---- */

/* Marks what is under the cursor. */
void view_mark_here(viewer *v);
/* Draws a pin for each mark; dim if the surface hides it. */
void view_marked_draw(viewer *v);

/* ---- panels/view_profile_show.c ---- */

/* Begins the profile of the last measured line. Shows a note. */
void view_profile_last(viewer *v);
/* Notices that a profile was made or saved. */
void view_profile_turn(viewer *v);
/* Closes the chart. False if none is shown. */
bool view_profile_close(viewer *v);
void view_profile_draw(const viewer *v);

/* ---- view_draw.c ---- */

/* Draws the picture if it changed, and the panels if they changed. Errors: those of drawing. */
stp_status view_draw(viewer *v, stp_error *err);

/* ---- panels/: view_panels*.c, view_marks.c, view_legend.c ---- */

void view_panels_draw(viewer *v);
void view_panel_models(viewer *v);
void view_panel_camera(viewer *v);
void view_panel_quality(viewer *v);
void view_panel_colour(viewer *v);
void view_panel_surface(viewer *v);
void view_panel_clip(viewer *v);
void view_panel_measure(viewer *v);
void view_panel_profile(viewer *v);
void view_panel_marks(viewer *v);
void view_panel_kept(viewer *v);
void view_panel_shot(viewer *v);
void view_panel_numbers(viewer *v);
/* Draws the pivot, the clip box, the measured lines, the status line and the help. */
void view_marks_draw(viewer *v);
/* Formats an intensity from 0 to 1 in the scans' own numbers, rounded as far as it is known, or in
 * per cent if they are not known. top: view_scene.intensity_top. */
void view_format_intensity(double top, double intensity, char out[64]);
/* Draws the colour bar of elevation and intensity at the left end of a picture; nothing if other
 * colours are shown. */
void view_legend_draw(const viewer *v, double left);
/* A press on a handle of the clip box takes the handle; later events move it. True if the clip box
 * used the event. */
bool view_clip_handle(viewer *v, const stp_window_event *event);
/* Switches the clip box on or off. An empty clip box becomes the scene's box. */
void view_clip_toggle(viewer *v);

#endif
