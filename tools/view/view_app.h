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

#endif
