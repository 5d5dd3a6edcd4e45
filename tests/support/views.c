/* Makes views of a model. */
#include "tests/support/views.h"

#include <math.h>

stp_view views_look(stp_dvec3 eye, stp_dvec3 look, double fovy_deg, const stp_ball *ball, int width,
                    int height)
{
    stp_dvec3 back = stp_dvec3_normalize(stp_dvec3_sub(eye, look));
    stp_dvec3 up = fabs(back.y) < 0.9 ? (stp_dvec3){0.0, 1.0, 0.0} : (stp_dvec3){0.0, 0.0, 1.0};
    stp_dvec3 right = stp_dvec3_normalize(stp_dvec3_cross(up, back));
    double distance = stp_dvec3_dot(stp_dvec3_sub(eye, ball->centre), back);
    double near_depth = 1e-5 * ball->radius;
    return (stp_view){.eye = eye,
                      .right = right,
                      .up = stp_dvec3_cross(back, right),
                      .back = back,
                      .f = height / (2.0 * tan(fovy_deg * M_PI / 360.0)),
                      .near_depth = near_depth,
                      .ball_near = fmax(near_depth, distance - ball->radius),
                      .ball_far = fmax(2.0 * near_depth, distance + ball->radius),
                      .width = width,
                      .height = height};
}

static stp_dvec3 direction(int i)
{
    int place = i < 13 ? i : i + 1; /* 26 of the cube's 27 places: not the middle */
    return stp_dvec3_normalize((stp_dvec3){place % 3 - 1.0, place / 3 % 3 - 1.0, place / 9 - 1.0});
}

/* The disc whose centre is nearest to a place: the same in whatever order a file has them. */
static const promise_disc *nearest_disc(const promise_disc *discs, size_t count, stp_dvec3 place)
{
    const promise_disc *nearest = discs;
    double least = INFINITY;
    for (size_t i = 0; i < count; i++) {
        double distance = stp_dvec3_length(stp_dvec3_sub(discs[i].centre, place));
        if (distance < least)
            nearest = &discs[i];
        least = fmin(least, distance);
    }
    return nearest;
}

stp_view views_get(int i, const stp_ball *ball, const promise_disc *discs, size_t count, int width,
                   int height)
{
    static const double fovy[VIEWS_CLOSE] = {45, 100, 60, 100, 30, 90, 100, 75, 45, 100};
    static const double away[VIEWS_CLOSE] = {0.1, 0.02, 0.3, 0.1, 0.5, 0.05, 0.3, 0.02, 0.2, 0.5};
    static const double slant[VIEWS_CLOSE] = {0.0, 0.0, 1.0, 3.0, 0.5, 1.0, 6.0, 2.0, 10.0, 1.0};
    if (i < VIEWS_DIRECTIONS) {
        double half = atan(tan(22.5 * M_PI / 180.0) * fmin(1.0, (double)width / height));
        stp_dvec3 eye =
            stp_dvec3_add(ball->centre, stp_dvec3_scale(direction(i), ball->radius / sin(half)));
        return views_look(eye, ball->centre, 45.0, ball, width, height);
    }
    int k = i - VIEWS_DIRECTIONS;
    stp_dvec3 place = stp_dvec3_scale(direction(5 * k % VIEWS_DIRECTIONS), 0.4 * ball->radius);
    const promise_disc *disc = nearest_disc(discs, count, stp_dvec3_add(ball->centre, place));
    stp_dvec3 outward = disc->normal;
    if (stp_dvec3_dot(outward, stp_dvec3_sub(disc->centre, ball->centre)) < 0.0)
        outward = stp_dvec3_scale(outward, -1.0);
    stp_dvec3 aside = stp_dvec3_cross(outward, (stp_dvec3){0.36, 0.48, 0.8});
    stp_dvec3 towards = stp_dvec3_normalize(
        stp_dvec3_add(outward, stp_dvec3_scale(stp_dvec3_normalize(aside), slant[k])));
    stp_dvec3 eye = stp_dvec3_add(disc->centre, stp_dvec3_scale(towards, away[k] * ball->radius));
    return views_look(eye, disc->centre, fovy[k], ball, width, height);
}
