/* Predicts position and axes linearly. */
#include "runtime/stream/motion.h"

#include "base/vec.h"

bool stp_view_equal(const stp_view *a, const stp_view *b)
{
    return stp_dvec3_equal(a->eye, b->eye) && stp_dvec3_equal(a->right, b->right) &&
           stp_dvec3_equal(a->up, b->up) && stp_dvec3_equal(a->back, b->back) && a->f == b->f &&
           a->near_depth == b->near_depth && a->width == b->width && a->height == b->height &&
           a->orthographic == b->orthographic && a->offset[0] == b->offset[0] &&
           a->offset[1] == b->offset[1];
}

static stp_dvec3 go_on(stp_dvec3 last, stp_dvec3 now, double steps)
{
    return stp_dvec3_add(now, stp_dvec3_scale(stp_dvec3_sub(now, last), steps));
}

/* Continues the turn, with axes made orthonormal again; false if the turn is too fast to
 * continue. */
static bool turn_on(const stp_view *last, const stp_view *now, double steps, stp_view *out)
{
    stp_dvec3 back = go_on(last->back, now->back, steps), up = go_on(last->up, now->up, steps);
    if (stp_dvec3_dot(back, now->back) < 0.5)
        return false;
    out->back = stp_dvec3_normalize(back);
    stp_dvec3 right = stp_dvec3_cross(up, out->back);
    if (!(stp_dvec3_length(right) > 0.1))
        return false;
    out->right = stp_dvec3_normalize(right);
    out->up = stp_dvec3_cross(out->back, out->right);
    return true;
}

bool stp_motion_follow(stp_motion *m, const stp_view *view, double time_s, stp_view *ahead)
{
    double passed = time_s - m->last_s;
    bool moves = m->known && passed > 0.0 && passed < STP_MOTION_PAUSE_S &&
                 view->orthographic == m->last.orthographic && !stp_view_equal(view, &m->last);
    if (moves) {
        double steps = STP_MOTION_AHEAD_S / passed;
        *ahead = *view;
        ahead->eye = go_on(m->last.eye, view->eye, steps);
        moves = turn_on(&m->last, view, steps, ahead);
    }
    *m = (stp_motion){.last = *view, .last_s = time_s, .known = true};
    return moves;
}
