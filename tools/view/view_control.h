/* What the user's hand does to the camera and the way of drawing.
 *
 * No window and no OpenGL in it: events come in, a camera and parameters come out, and wishes that
 * the program fulfils. Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_CONTROL_H
#define STP_TOOLS_VIEW_VIEW_CONTROL_H

#include "runtime/camera/orbit.h"
#include "runtime/cut/model.h"
#include "runtime/stipple.h"
#include "runtime/window/window.h"

typedef enum view_drag { VIEW_REST, VIEW_TURN, VIEW_PAN, VIEW_LOOK } view_drag;
#define VIEW_NAVIGATIONS "orbit|fly|walk"
typedef enum view_navigation { VIEW_ORBIT, VIEW_FLY, VIEW_WALK } view_navigation;

/* The depth of the last picture at a pixel, 0 where nothing is. */
typedef double view_depth(void *context, int x, int y);
/* Height along the up axis of the ground under a position; false if there is none. */
typedef bool view_ground_at(void *context, stp_dvec3 position, stp_dvec3 up, double *height);

/* What the program is asked for: bits of view_control.wants, reset by who fulfils them. */
enum {
    VIEW_WANTS_QUIT = 1u << 0,
    VIEW_WANTS_HOME = 1u << 1,
    VIEW_WANTS_RANGE = 1u << 2, /* of another colour */
    VIEW_WANTS_SHOT = 1u << 3,
    VIEW_WANTS_RECORD = 1u << 4, /* begin or end */
    VIEW_WANTS_KEEP = 1u << 5,   /* this view */
    VIEW_WANTS_RECALL = 1u << 6, /* the kept view number `recall` */
    VIEW_WANTS_PANELS = 1u << 7,
    VIEW_WANTS_HELP = 1u << 8,
    VIEW_WANTS_FULL_SCREEN = 1u << 9,
    VIEW_WANTS_CLIP = 1u << 10,
    VIEW_WANTS_ESCAPE = 1u << 11, /* end what is going on, or all */
    VIEW_WANTS_PICK = 1u << 12    /* of what was clicked, at `click` */
};

typedef struct view_control {
    stp_camera camera;
    stp_draw_params params;
    stp_ball ball;          /* the scene's */
    stp_view view;          /* of the last picture */
    view_depth *depth;      /* asked for what is under the cursor */
    view_ground_at *ground; /* asked where to walk */
    void *context;          /* for both */
    double speed;           /* of flying and walking, units a second */
    double eye_height;      /* above the ground, walking */
    view_navigation navigation;
    uint32_t held; /* keys that move, VIEW_HELD_* of view_move.h */
    view_drag drag;
    int button;                /* that drags */
    double x, y;               /* where the cursor was last */
    double press[2], click[2]; /* where the button went down; where it was a click */
    double click_at_s;         /* when that was */
    stp_dvec3 pivot;           /* what the drag holds */
    double pivot_depth;
    double pivot_until_s; /* how long it is shown */
    stp_dvec3 centre;     /* a pivot that was set, if has_centre */
    bool has_centre;
    bool moved;     /* the cursor since the button went down, further than a click allows */
    bool measuring; /* clicks are points */
    bool changed;   /* the picture: set here, reset by the caller */
    int recall;
    uint32_t colours; /* bits by stp_colour: what the model has */
    uint32_t wants;
} view_control;

/* What keys and panels make of the threshold. */
#define VIEW_THRESHOLD_LEAST_PX (1.0 / 16.0)
#define VIEW_THRESHOLD_MOST_PX 64.0

/* How long a pivot is shown after the hand let go. */
#define VIEW_PIVOT_S 0.8

/* Whether the panels get a turn of their own after an event, so that no press or release is lost on
 * them. A key that is held repeats many times a frame: repeats have none, or they would queue up
 * and the camera would go on long after the key is released. */
bool view_control_ends_turn(const stp_window_event *event);
void view_control_handle(view_control *control, const stp_window_event *event);
/* Looks along a direction from the same distance at the middle of the scene. */
void view_control_face(view_control *control, stp_dvec3 direction, stp_dvec3 up);
/* Perspective to orthographic or back, so that what lies about the pivot keeps its size. */
void view_control_project(view_control *control, bool orthographic);
void view_control_navigate(view_control *control, view_navigation navigation);
/* What is under a pixel; where nothing was drawn, as deep as the scene's middle. */
stp_dvec3 view_control_point(const view_control *control, double x, double y, double *depth);

#endif
