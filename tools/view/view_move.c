/* Flying and walking. */
#include "tools/view/view_move.h"

/* Seconds to cross the scene's radius. */
#define CROSSING_S 4.0
#define FAST 5.0
#define SPEED_NOTCH 1.25
/* Eye height as a fraction of the scene's radius, if the scene is too small for a person. */
#define EYE_SHARE 0.05
#define EYE_MAN 1.7
/* Walking speed, in eye heights per second. */
#define WALK_SPEED 3.0
/* In eye heights: from higher up, landing goes elsewhere. */
#define LANDING 30.0
/* Time in which a step up or down shrinks to a third. */
#define STEP_S 0.12
/* In eye heights: a smaller step is done. */
#define STEP_DONE 1e-3
/* A frame that takes longer than this moves only this far. */
#define FRAME_MOST_S 0.25

bool view_move_key(view_control *c, const stp_window_event *event)
{
    static const struct {
        int key;
        uint32_t held;
    } keys[] = {
        {'W', VIEW_HELD_FORWARD},
        {'S', VIEW_HELD_BACK},
        {'A', VIEW_HELD_LEFT},
        {'D', VIEW_HELD_RIGHT},
        {'E', VIEW_HELD_UP},
        {'Q', VIEW_HELD_DOWN},
        {STP_KEY_UP, VIEW_HELD_FORWARD},
        {STP_KEY_DOWN, VIEW_HELD_BACK},
        {STP_KEY_LEFT, VIEW_HELD_LEFT},
        {STP_KEY_RIGHT, VIEW_HELD_RIGHT},
        {STP_KEY_PAGE_UP, VIEW_HELD_UP},
        {STP_KEY_PAGE_DOWN, VIEW_HELD_DOWN},
        {STP_KEY_SHIFT, VIEW_HELD_FAST},
    };
    if (c->navigation == VIEW_ORBIT || event->control)
        return false;
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        if (keys[i].key != event->key)
            continue;
        c->held = event->down ? c->held | keys[i].held : c->held & ~keys[i].held;
        return true;
    }
    return false;
}

void view_move_speed(view_control *c, double notches)
{
    double speed = c->speed * pow(SPEED_NOTCH, notches);
    c->speed =
        fmin(fmax(speed, VIEW_SPEED_LEAST * c->ball.radius), VIEW_SPEED_MOST * c->ball.radius);
}

void view_move_reset(view_control *c)
{
    c->eye_height = fmin(EYE_MAN, EYE_SHARE * c->ball.radius);
    c->speed =
        c->navigation == VIEW_WALK ? WALK_SPEED * c->eye_height : c->ball.radius / CROSSING_S;
}

void view_move_land(view_control *c)
{
    double ground = 0.0, depth = 0.0;
    stp_dvec3 up = stp_dvec3_normalize(c->camera.up);
    stp_dvec3 back = stp_dvec3_normalize(stp_dvec3_sub(c->camera.eye, c->camera.look));
    stp_dvec3 level = stp_dvec3_sub(back, stp_dvec3_scale(up, stp_dvec3_dot(back, up)));
    if (c->ground(c->context, c->camera.eye, up, &ground) &&
        stp_dvec3_dot(c->camera.eye, up) - ground < LANDING * c->eye_height)
        return;
    stp_dvec3 at = view_control_point(c, 0.5 * c->view.width, 0.5 * c->view.height, &depth);
    if (c->has_centre)
        at = c->centre;
    c->camera.eye = stp_dvec3_add(at, stp_dvec3_scale(up, c->eye_height));
    c->camera.look =
        stp_dvec3_sub(c->camera.eye, stp_dvec3_scale(stp_dvec3_normalize(level), c->ball.radius));
    c->changed = true;
}

static double axis(uint32_t held, uint32_t plus, uint32_t minus)
{
    return (held & plus ? 1.0 : 0.0) - (held & minus ? 1.0 : 0.0);
}

static void shift(stp_camera *camera, stp_dvec3 by)
{
    camera->eye = stp_dvec3_add(camera->eye, by);
    camera->look = stp_dvec3_add(camera->look, by);
}

/* Moves towards the eye height above the ground. True while on the way. */
static bool step(view_control *c, stp_dvec3 up, double seconds)
{
    double ground = 0.0;
    if (!c->ground(c->context, c->camera.eye, up, &ground))
        return false;
    double wanted = ground + c->eye_height - stp_dvec3_dot(c->camera.eye, up);
    bool done = fabs(wanted) < STEP_DONE * c->eye_height;
    shift(&c->camera, stp_dvec3_scale(up, done ? wanted : wanted * (1.0 - exp(-seconds / STEP_S))));
    return !done;
}

bool view_move_advance(view_control *c, double seconds)
{
    const uint32_t moving = ~(uint32_t)VIEW_HELD_FAST;
    bool walks = c->navigation == VIEW_WALK, held = (c->held & moving) != 0;
    if (c->navigation == VIEW_ORBIT || (!held && !walks))
        return false;
    seconds = fmin(seconds, FRAME_MOST_S);
    stp_dvec3 up = stp_dvec3_normalize(c->camera.up);
    stp_dvec3 back = stp_dvec3_normalize(stp_dvec3_sub(c->camera.eye, c->camera.look));
    stp_dvec3 right = stp_dvec3_normalize(stp_dvec3_cross(up, back));
    stp_dvec3 forward = walks ? stp_dvec3_cross(up, right) : stp_dvec3_scale(back, -1.0);
    double length = c->speed * seconds * (c->held & VIEW_HELD_FAST ? FAST : 1.0);
    stp_dvec3 by = stp_dvec3_scale(forward, axis(c->held, VIEW_HELD_FORWARD, VIEW_HELD_BACK));
    by = stp_dvec3_add(by, stp_dvec3_scale(right, axis(c->held, VIEW_HELD_RIGHT, VIEW_HELD_LEFT)));
    if (!walks)
        by = stp_dvec3_add(by, stp_dvec3_scale(up, axis(c->held, VIEW_HELD_UP, VIEW_HELD_DOWN)));
    by = stp_dvec3_scale(by, length);
    shift(&c->camera, by);
    bool steps = walks && step(c, up, seconds);
    c->changed = c->changed || held || steps;
    return held || steps;
}
