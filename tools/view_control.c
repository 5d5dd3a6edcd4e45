/* Events to camera and parameters. */
#include "tools/view_control.h"

/* A drag across the smaller side of the picture turns by half a circle. */
#define TURN_RAD 3.14159265358979323846
/* A notch of the wheel scales the distance by this. */
#define WHEEL_FACTOR 0.85
#define THRESHOLD_LEAST_PX (1.0 / 16.0)
#define THRESHOLD_MOST_PX 64.0

/* Depth to assume where nothing was drawn: the model's centre, or what the camera looks at. */
static double empty_depth(const view_control *c)
{
    double centre = stp_dvec3_dot(stp_dvec3_sub(c->view.eye, c->ball.centre), c->view.back);
    return centre > c->view.near_depth
               ? centre
               : stp_dvec3_length(stp_dvec3_sub(c->camera.eye, c->camera.look));
}

static stp_dvec3 point_under(const view_control *c, double x, double y, double *depth)
{
    *depth = c->depth(c->context, (int)floor(x), (int)floor(y));
    if (!(*depth > 0.0))
        *depth = empty_depth(c);
    return stp_view_unproject(&c->view, x, y, *depth);
}

static void begin_drag(view_control *c, const stp_window_event *event)
{
    if (c->drag != VIEW_REST || event->button > STP_WINDOW_MIDDLE)
        return;
    c->drag = event->button == STP_WINDOW_LEFT && !event->shift ? VIEW_TURN : VIEW_PAN;
    c->button = event->button;
    c->x = event->x;
    c->y = event->y;
    c->pivot = point_under(c, event->x, event->y, &c->pivot_depth);
}

static void go_on(view_control *c, const stp_window_event *event)
{
    double dx = event->x - c->x, dy = event->y - c->y;
    int side = c->view.width < c->view.height ? c->view.width : c->view.height;
    if (c->drag == VIEW_REST || side < 1)
        return;
    if (c->drag == VIEW_TURN)
        stp_camera_turn(&c->camera, c->pivot, dx * TURN_RAD / side, -dy * TURN_RAD / side);
    else
        stp_camera_pan(&c->camera, c->pivot_depth, dx, dy, c->view.height);
    c->x = event->x;
    c->y = event->y;
    c->changed = true;
}

static void zoom(view_control *c, const stp_window_event *event)
{
    double depth = 0.0;
    stp_dvec3 point = point_under(c, event->x, event->y, &depth);
    stp_camera_zoom(&c->camera, &c->ball, point, pow(WHEEL_FACTOR, event->wheel));
    c->changed = true;
}

static void set_threshold(stp_draw_params *params, double px)
{
    params->threshold_px = fmin(fmax(px, THRESHOLD_LEAST_PX), THRESHOLD_MOST_PX);
    params->every_sample = false;
}

static int cycle(int value, int count, bool back)
{
    return (value + (back ? count - 1 : 1)) % count;
}

/* The next colour that the model has; RGB and NONE always are. */
static void cycle_colour(view_control *c, bool back)
{
    int colour = (int)c->params.colour;
    do
        colour = cycle(colour, STP_COLOUR_ELEVATION + 1, back);
    while (!(c->colours >> colour & 1));
    c->params.colour = (stp_colour)colour;
    c->wants_range = true;
}

static void handle_key(view_control *c, uint32_t character)
{
    stp_draw_params *p = &c->params;
    bool back = character >= 'A' && character <= 'Z';
    c->changed = true;
    switch (back ? character - 'A' + 'a' : character) {
    case '+':
    case '=':
        if (!p->every_sample) /* nothing is finer than that */
            set_threshold(p, 0.5 * p->threshold_px);
        break;
    case '-':
    case '_':
        set_threshold(p, 2.0 * p->threshold_px);
        break;
    case 'l':
        p->lod = (stp_lod)cycle((int)p->lod, STP_LOD_COMPUTE + 1, back);
        break;
    case 'r':
        p->reconstruct =
            (stp_reconstruct)cycle((int)p->reconstruct, STP_RECONSTRUCT_POINTS + 1, back);
        break;
    case 's':
        p->shade = (stp_shade)cycle((int)p->shade, STP_SHADE_CONFIDENCE + 1, back);
        break;
    case 'c':
        cycle_colour(c, back);
        break;
    case 'p':
        p->palette = (stp_palette)cycle((int)p->palette, STP_PALETTE_HEAT + 1, back);
        break;
    case 'h':
        c->wants_home = true;
        break;
    case 'q':
        c->wants_quit = true;
        break;
    default:
        c->changed = false;
    }
}

void view_control_handle(view_control *c, const stp_window_event *event)
{
    switch (event->kind) {
    case STP_WINDOW_CHARACTER:
        handle_key(c, event->character);
        break;
    case STP_WINDOW_PRESS:
        begin_drag(c, event);
        break;
    case STP_WINDOW_MOVE:
        go_on(c, event);
        break;
    case STP_WINDOW_RELEASE:
        if (event->button == c->button)
            c->drag = VIEW_REST;
        break;
    case STP_WINDOW_WHEEL:
        zoom(c, event);
        break;
    case STP_WINDOW_REFRESH:
        c->changed = true;
        break;
    case STP_WINDOW_ESCAPE:
    case STP_WINDOW_CLOSE:
        c->wants_quit = true;
        break;
    }
}
