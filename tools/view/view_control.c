/* Turns events into changes of camera and parameters. */
#include "tools/view/view_control.h"

#include "tools/view/view_move.h"

#include <string.h>

/* A drag across the smaller side of the picture turns by half a circle. */
#define TURN_RAD 3.14159265358979323846
/* A notch of the wheel multiplies the distance by this. */
#define WHEEL_FACTOR 0.85
/* A press and a release this near to each other are a click. Two clicks within this time are a
 * double click. */
#define CLICK_PX 4.0
#define DOUBLE_CLICK_S 0.4

bool view_control_ends_turn(const stp_window_event *event)
{
    return event->kind == STP_WINDOW_PRESS || event->kind == STP_WINDOW_RELEASE ||
           (event->kind == STP_WINDOW_KEY && !event->repeated);
}

static void begin_drag(view_control *c, const stp_window_event *event)
{
    if (c->drag != VIEW_REST || event->button > STP_WINDOW_MIDDLE)
        return;
    bool turns = event->button == STP_WINDOW_LEFT && !event->shift;
    c->drag = !turns ? VIEW_PAN : c->navigation == VIEW_ORBIT ? VIEW_TURN : VIEW_LOOK;
    c->button = event->button;
    c->x = c->press[0] = event->x;
    c->y = c->press[1] = event->y;
    c->moved = false;
    c->pivot = view_control_point(c, event->x, event->y, &c->pivot_depth);
    if (c->drag == VIEW_TURN && c->has_centre)
        c->pivot = c->centre;
}

static void go_on(view_control *c, const stp_window_event *event)
{
    double dx = event->x - c->x, dy = event->y - c->y;
    int side = c->view.width < c->view.height ? c->view.width : c->view.height;
    if (c->drag != VIEW_REST && !c->moved)
        c->moved = hypot(event->x - c->press[0], event->y - c->press[1]) > CLICK_PX;
    if (c->drag == VIEW_REST || side < 1 || !c->moved)
        return;
    if (c->drag == VIEW_TURN)
        stp_camera_turn(&c->camera, c->pivot, dx * TURN_RAD / side, -dy * TURN_RAD / side);
    else if (c->drag == VIEW_LOOK)
        stp_camera_turn(&c->camera, c->camera.eye, 2.0 * dx / c->view.f, -2.0 * dy / c->view.f);
    else
        stp_camera_pan(&c->camera, c->pivot_depth, dx, dy, c->view.height);
    if (c->drag == VIEW_TURN)
        c->pivot_until_s = event->at_s + VIEW_PIVOT_S;
    c->x = event->x;
    c->y = event->y;
    c->changed = true;
}

/* Sets a pivot that stays, or removes it if nothing is under the cursor. */
static void set_centre(view_control *c, double x, double y, double at_s)
{
    double depth = c->depth(c->context, (int)floor(x), (int)floor(y));
    c->has_centre = depth > 0.0;
    if (c->has_centre) {
        c->centre = c->pivot = stp_view_unproject(&c->view, x, y, depth);
        c->pivot_until_s = at_s + VIEW_PIVOT_S;
    }
}

static void end_drag(view_control *c, const stp_window_event *event)
{
    if (c->drag == VIEW_REST || event->button != c->button)
        return;
    bool click = !c->moved && event->button == STP_WINDOW_LEFT;
    c->drag = VIEW_REST;
    if (!click)
        return;
    bool second = c->click_at_s > 0.0 && event->at_s - c->click_at_s < DOUBLE_CLICK_S &&
                  hypot(event->x - c->click[0], event->y - c->click[1]) <= CLICK_PX;
    c->click[0] = event->x;
    c->click[1] = event->y;
    c->click_at_s = second ? 0.0 : event->at_s;
    if (second && !c->measuring)
        set_centre(c, event->x, event->y, event->at_s);
    else
        c->wants |= VIEW_WANTS_PICK;
}

static void zoom(view_control *c, const stp_window_event *event)
{
    double depth = 0.0;
    if (c->navigation != VIEW_ORBIT) {
        view_move_speed(c, event->wheel);
        return;
    }
    stp_dvec3 point = view_control_point(c, event->x, event->y, &depth);
    stp_camera_zoom(&c->camera, &c->ball, point, pow(WHEEL_FACTOR, event->wheel));
    c->changed = true;
}

void view_control_face(view_control *c, stp_dvec3 direction, stp_dvec3 up)
{
    int width = c->view.width > 0 ? c->view.width : 1,
        height = c->view.height > 0 ? c->view.height : 1;
    stp_camera camera =
        stp_camera_around(&c->ball, direction, up, c->camera.fovy_deg, width, height);
    camera.height = c->camera.height;
    if (camera.height > 0.0)
        camera.height = 2.0 * c->ball.radius * (width < height ? (double)height / width : 1.0);
    c->camera = camera;
    c->changed = true;
}

void view_control_project(view_control *c, bool orthographic)
{
    stp_camera *camera = &c->camera;
    stp_dvec3 to_eye = stp_dvec3_sub(camera->eye, camera->look);
    stp_dvec3 back = stp_dvec3_normalize(to_eye);
    stp_dvec3 held = c->has_centre ? c->centre : c->ball.centre;
    double depth = stp_dvec3_dot(stp_dvec3_sub(camera->eye, held), back);
    double unit = 2.0 * tan(0.5 * camera->fovy_deg * TURN_RAD / 180.0);
    if (orthographic == (camera->height > 0.0))
        return;
    if (orthographic) {
        camera->height = unit * (depth > 0.0 ? depth : stp_dvec3_length(to_eye));
    } else { /* from a distance at which it looks as large */
        double distance = camera->height / unit;
        stp_dvec3 shift = stp_dvec3_scale(back, distance - depth);
        camera->eye = stp_dvec3_add(camera->eye, shift);
        camera->look = stp_dvec3_sub(camera->eye, stp_dvec3_scale(back, distance));
        camera->height = 0.0;
    }
    c->changed = true;
}

void view_control_navigate(view_control *c, view_navigation navigation)
{
    if (c->navigation == navigation)
        return;
    c->navigation = navigation;
    c->held = 0;
    if (navigation != VIEW_ORBIT) /* moving needs perspective */
        view_control_project(c, false);
    view_move_reset(c);
    if (navigation == VIEW_WALK)
        view_move_land(c);
}

static void set_threshold(stp_draw_params *params, double px)
{
    params->threshold_px = fmin(fmax(px, VIEW_THRESHOLD_LEAST_PX), VIEW_THRESHOLD_MOST_PX);
    params->every_sample = false;
}

static int cycle(int value, int count, bool back)
{
    return (value + (back ? count - 1 : 1)) % count;
}

/* Goes to the next colour that the model has. RGB and NONE always exist. */
static void cycle_colour(view_control *c, bool back)
{
    int colour = (int)c->params.colour;
    do
        colour = cycle(colour, STP_COLOUR_FIT + 1, back);
    while (!(c->colours >> colour & 1));
    c->params.colour = (stp_colour)colour;
    c->wants |= VIEW_WANTS_RANGE;
}

/* Handles keys that change the drawing. False if the key is none of them. */
static bool handle_drawing_key(view_control *c, uint32_t key, bool back)
{
    stp_draw_params *p = &c->params;
    switch (key) {
    case '+':
    case '=':
        if (!p->every_sample) /* every sample is already the finest */
            set_threshold(p, 0.5 * p->threshold_px);
        return true;
    case '-':
    case '_':
        set_threshold(p, 2.0 * p->threshold_px);
        return true;
    case 'l':
        p->lod = (stp_lod)cycle((int)p->lod, STP_LOD_LAST + 1, back);
        return true;
    case 'r':
        p->reconstruct =
            (stp_reconstruct)cycle((int)p->reconstruct, STP_RECONSTRUCT_LAST + 1, back);
        return true;
    case 's':
        p->shade = (stp_shade)cycle((int)p->shade, STP_SHADE_LAST + 1, back);
        return true;
    case 'u':
        p->shade = p->shade == STP_SHADE_UNLIT ? STP_SHADE_PHONG : STP_SHADE_UNLIT;
        return true;
    case 'c':
        cycle_colour(c, back);
        return true;
    case 'g':
        p->palette = (stp_palette)cycle((int)p->palette, STP_PALETTE_HEAT + 1, back);
        return true;
    case 'k':
        p->edl = p->edl > 0.0 ? 0.0 : 1.0;
        return true;
    default:
        return false;
    }
}

static void handle_character(view_control *c, uint32_t character)
{
    static const char moving[] = "wasdqe";
    static const struct {
        uint32_t key, wants;
    } wishes[] = {
        {'h', VIEW_WANTS_HOME},    {'p', VIEW_WANTS_SHOT}, {'b', VIEW_WANTS_KEEP},
        {'x', VIEW_WANTS_CLIP},    {'q', VIEW_WANTS_QUIT}, {'f', VIEW_WANTS_MARK},
        {'t', VIEW_WANTS_PROFILE},
    };
    bool back = character >= 'A' && character <= 'Z';
    uint32_t key = back ? character - 'A' + 'a' : character;
    if (c->navigation != VIEW_ORBIT && key < 128 && key > 0 && strchr(moving, (int)key) != NULL)
        return; /* these keys move the camera */
    if (handle_drawing_key(c, key, back)) {
        c->changed = true;
        return;
    }
    for (size_t i = 0; i < sizeof wishes / sizeof *wishes; i++)
        c->wants |= wishes[i].key == key ? wishes[i].wants : 0u;
    if (key >= '1' && key <= '9') {
        c->recall = (int)(key - '1');
        c->wants |= VIEW_WANTS_RECALL;
    }
    if (key == 'n')
        view_control_navigate(c, (view_navigation)cycle((int)c->navigation, VIEW_WALK + 1, back));
    if (key == 'o' && c->navigation == VIEW_ORBIT)
        view_control_project(c, !(c->camera.height > 0.0));
    if (key == 'm')
        c->measuring = !c->measuring;
}

static void handle_key(view_control *c, const stp_window_event *event)
{
    if (view_move_key(c, event) || !event->down || event->repeated)
        return;
    if (event->key == STP_KEY_ESCAPE)
        c->wants |= VIEW_WANTS_ESCAPE;
    if (event->key == STP_KEY_TAB)
        c->wants |= VIEW_WANTS_PANELS;
    if (event->key == STP_KEY_F1)
        c->wants |= VIEW_WANTS_HELP;
    if (event->key == STP_KEY_F11)
        c->wants |= VIEW_WANTS_FULL_SCREEN;
    if (event->key == 'R' && event->control)
        c->wants |= VIEW_WANTS_RECORD;
    if (event->key == 'O' && event->control)
        c->wants |= VIEW_WANTS_OPEN;
}

void view_control_handle(view_control *c, const stp_window_event *event)
{
    switch (event->kind) {
    case STP_WINDOW_CHARACTER:
        handle_character(c, event->character);
        break;
    case STP_WINDOW_KEY:
        handle_key(c, event);
        break;
    case STP_WINDOW_PRESS:
        begin_drag(c, event);
        break;
    case STP_WINDOW_MOVE:
        go_on(c, event);
        break;
    case STP_WINDOW_RELEASE:
        end_drag(c, event);
        break;
    case STP_WINDOW_WHEEL:
        zoom(c, event);
        break;
    case STP_WINDOW_BLUR:
        c->held = 0;
        break;
    case STP_WINDOW_REFRESH:
        c->changed = true;
        break;
    case STP_WINDOW_CLOSE:
        c->wants |= VIEW_WANTS_QUIT;
        break;
    case STP_WINDOW_DROP:
        break;
    }
}
