/* What the user's hand does to the camera and the way of drawing.
 *
 * No window and no OpenGL in it: events come in, a camera and parameters come out.
 * Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_CONTROL_H
#define STP_TOOLS_VIEW_CONTROL_H

#include "runtime/model.h"
#include "runtime/orbit.h"
#include "runtime/stipple.h"
#include "runtime/window/window.h"

/* The lines of `stipple view --help` about the hand. */
#define VIEW_KEYS                                                                                  \
    "Mouse: left drag turns the model about the point under the cursor; right or middle drag, "    \
    "or\n"                                                                                         \
    "shift and left, shifts it; the wheel comes nearer to the point under the cursor.\n"           \
    "Keys (with shift the cycle runs back):\n"                                                     \
    "  + -      finer, coarser: halve, double the threshold\n"                                     \
    "  L        who chooses levels: geometry shader, cpu, full (every sample), compute shader\n"   \
    "  R        how gaps are closed: gauss, box, points (not at all)\n"                            \
    "  S        what is shown: phong, lambert, normal, depth, level, chunk, error, confidence\n"   \
    "  C        what colours samples: rgb, none, intensity, class, elevation, as the model has "   \
    "them\n"                                                                                       \
    "  P        palette of intensity and elevation: auto, grey, viridis, heat\n"                   \
    "  H        home: the view it began with\n"                                                    \
    "  Q Esc    quit"

typedef enum view_drag { VIEW_REST, VIEW_TURN, VIEW_PAN } view_drag;

/* The depth of the last picture at a pixel, 0 where nothing is. */
typedef double view_depth(void *context, int x, int y);

typedef struct view_control {
    stp_camera camera;
    stp_draw_params params;
    stp_ball ball;     /* the model's */
    stp_view view;     /* of the last picture */
    view_depth *depth; /* asked for what is under the cursor */
    void *context;     /* for depth */
    view_drag drag;
    int button;      /* that drags */
    double x, y;     /* where the cursor was last */
    stp_dvec3 pivot; /* what the drag holds */
    double pivot_depth;
    uint32_t colours;                     /* bits by stp_colour: what the model has */
    bool changed, wants_home, wants_quit; /* set here, reset by the caller */
    bool wants_range;                     /* likewise: of another colour */
} view_control;

void view_control_handle(view_control *control, const stp_window_event *event);

#endif
