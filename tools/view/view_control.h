/* Turns the user's input into changes of the camera and of the drawing parameters.
 *
 * It knows no window and no OpenGL: events come in; a camera, parameters and wishes for the program
 * come out. Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_CONTROL_H
#define STP_TOOLS_VIEW_VIEW_CONTROL_H

#include "runtime/camera/orbit.h"
#include "runtime/cut/model.h"
#include "runtime/stipple.h"
#include "runtime/window/window.h"

typedef enum view_drag { VIEW_REST, VIEW_TURN, VIEW_PAN, VIEW_LOOK } view_drag;
#define VIEW_NAVIGATIONS "orbit|fly|walk"
typedef enum view_navigation { VIEW_ORBIT, VIEW_FLY, VIEW_WALK } view_navigation;

/* The depth of the last picture at a pixel; 0 if nothing was drawn there. */
typedef double view_depth(void *context, int x, int y);
/* Gets the height, along the up axis, of the ground under a position. False if there is none. */
typedef bool view_ground_at(void *context, stp_dvec3 position, stp_dvec3 up, double *height);

/* Wishes to the program: bits of view_control.wants. Whoever fulfils a wish resets its bit. */
enum {
    VIEW_WANTS_QUIT = 1u << 0,
    VIEW_WANTS_HOME = 1u << 1,
    VIEW_WANTS_RANGE = 1u << 2, /* colour range of another colour */
    VIEW_WANTS_SHOT = 1u << 3,
    VIEW_WANTS_RECORD = 1u << 4, /* begin or end */
    VIEW_WANTS_KEEP = 1u << 5,   /* this view */
    VIEW_WANTS_RECALL = 1u << 6, /* the kept view number `recall` */
    VIEW_WANTS_PANELS = 1u << 7,
    VIEW_WANTS_HELP = 1u << 8,
    VIEW_WANTS_FULL_SCREEN = 1u << 9,
    VIEW_WANTS_CLIP = 1u << 10,
    VIEW_WANTS_ESCAPE = 1u << 11,  /* end what is going on, or the program */
    VIEW_WANTS_PICK = 1u << 12,    /* pick what was clicked, at `click` */
    VIEW_WANTS_MARK = 1u << 13,    /* what is under the cursor */
    VIEW_WANTS_PROFILE = 1u << 14, /* of the last measured line */
    VIEW_WANTS_OPEN = 1u << 15     /* another file */
};

typedef struct view_control {
    stp_camera camera;
    stp_draw_params params;
    stp_ball ball;          /* the scene's */
    stp_view view;          /* view of the last picture */
    view_depth *depth;      /* callback: depth under the cursor */
    view_ground_at *ground; /* callback: ground to walk on */
    void *context;          /* for both */
    double speed;           /* of flying and walking, units per second */
    double eye_height;      /* above the ground when walking */
    view_navigation navigation;
    uint32_t held; /* pressed keys that move, VIEW_HELD_* of view_move.h */
    view_drag drag;
    int button;                /* the button that drags */
    double x, y;               /* last place of the cursor */
    double press[2], click[2]; /* where the button went down; where the last click was */
    double click_at_s;         /* time of that click */
    stp_dvec3 pivot;           /* the point that the drag holds */
    double pivot_depth;
    double pivot_until_s; /* time until which it is shown */
    stp_dvec3 centre;     /* a pivot that the user set, if has_centre */
    bool has_centre;
    bool moved;     /* the cursor moved further than a click allows since the button went down */
    bool measuring; /* clicks measure points */
    bool changed;   /* the picture must be drawn again: set here, reset by the caller */
    int recall;
    uint32_t colours; /* bit set of stp_colour: the colours that the model has */
    uint32_t wants;
} view_control;

/* Limits of the threshold that keys and panels set. */
#define VIEW_THRESHOLD_LEAST_PX (1.0 / 16.0)
#define VIEW_THRESHOLD_MOST_PX 64.0

/* How long a pivot is shown after the drag ends. */
#define VIEW_PIVOT_S 0.8

/* Whether the panels get a turn of their own after an event, so that no press or release is lost on
 * them. A key that is held repeats many times a frame: repeats have none, or they would queue up
 * and the camera would go on long after the key is released. */
bool view_control_ends_turn(const stp_window_event *event);
void view_control_handle(view_control *control, const stp_window_event *event);
/* Looks along a direction at the middle of the scene, from the same distance. */
void view_control_face(view_control *control, stp_dvec3 direction, stp_dvec3 up);
/* Switches between perspective and orthographic. What lies about the pivot keeps its size. */
void view_control_project(view_control *control, bool orthographic);
void view_control_navigate(view_control *control, view_navigation navigation);
/* Returns the point under a pixel. If nothing was drawn there, its depth is that of the scene's
 * middle. */
stp_dvec3 view_control_point(const view_control *control, double x, double y, double *depth);

#endif
