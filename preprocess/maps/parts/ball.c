/* The smallest ball around points. */
#include "preprocess/maps/parts/ball.h"

/* Passes until the ball is exact are few, since each takes the farthest point in. This many are
 * never needed. */
#define PASSES_MOST 200
/* Below this share of the edges' product, points have no volume, area or length. */
#define DEGENERATE 1e-14

/* Up to four points at which the ball touches. */
typedef struct support {
    stp_dvec3 points[5];
    unsigned count;
} support;

static double squared(stp_dvec3 a, stp_dvec3 b)
{
    const stp_dvec3 d = stp_dvec3_sub(a, b);
    return stp_dvec3_dot(d, d);
}

/* The centre of the least ball with both points on its surface, and so on for three and four. False
 * if the points have no such ball. */
static bool middle_of_three(const stp_dvec3 *p, stp_dvec3 *out)
{
    const stp_dvec3 a = stp_dvec3_sub(p[1], p[0]), b = stp_dvec3_sub(p[2], p[0]);
    const stp_dvec3 n = stp_dvec3_cross(a, b);
    const double aa = stp_dvec3_dot(a, a), bb = stp_dvec3_dot(b, b), nn = stp_dvec3_dot(n, n);
    if (!(nn > DEGENERATE * aa * bb))
        return false;
    const stp_dvec3 to = stp_dvec3_add(stp_dvec3_scale(stp_dvec3_cross(b, n), aa),
                                       stp_dvec3_scale(stp_dvec3_cross(n, a), bb));
    *out = stp_dvec3_add(p[0], stp_dvec3_scale(to, 0.5 / nn));
    return true;
}

static bool middle_of_four(const stp_dvec3 *p, stp_dvec3 *out)
{
    const stp_dvec3 a = stp_dvec3_sub(p[1], p[0]), b = stp_dvec3_sub(p[2], p[0]);
    const stp_dvec3 c = stp_dvec3_sub(p[3], p[0]);
    const stp_dvec3 bc = stp_dvec3_cross(b, c), ca = stp_dvec3_cross(c, a);
    const stp_dvec3 ab = stp_dvec3_cross(a, b);
    const double aa = stp_dvec3_dot(a, a), bb = stp_dvec3_dot(b, b), cc = stp_dvec3_dot(c, c);
    const double volume = stp_dvec3_dot(a, bc);
    if (!(volume * volume > DEGENERATE * aa * bb * cc))
        return false;
    const stp_dvec3 to = stp_dvec3_add(stp_dvec3_add(stp_dvec3_scale(bc, aa), //
                                                     stp_dvec3_scale(ca, bb)),
                                       stp_dvec3_scale(ab, cc));
    *out = stp_dvec3_add(p[0], stp_dvec3_scale(to, 0.5 / volume));
    return true;
}

static bool middle(const support *s, stp_dvec3 *out)
{
    switch (s->count) {
    case 1:
        *out = s->points[0];
        return true;
    case 2:
        *out = stp_dvec3_scale(stp_dvec3_add(s->points[0], s->points[1]), 0.5);
        return true;
    case 3:
        return middle_of_three(s->points, out);
    default:
        return middle_of_four(s->points, out);
    }
}

static double farthest_of(const support *s, stp_dvec3 centre)
{
    double most = 0.0;
    for (unsigned i = 0; i < s->count; i++)
        most = stp_max(most, squared(s->points[i], centre));
    return most;
}

/* The smallest ball around up to five points: of the balls of all subsets of up to four, the one
 * whose centre is nearest to its farthest point. *all becomes that subset. Returns the squared
 * radius. */
static double solve(support *all, stp_dvec3 *centre)
{
    double least = INFINITY;
    support best = *all;
    for (unsigned mask = 1; mask < 1u << all->count; mask++) {
        support some = {.count = 0};
        stp_dvec3 found;
        for (unsigned i = 0; i < all->count; i++)
            if (mask >> i & 1u)
                some.points[some.count++] = all->points[i];
        if (some.count > 4 || !middle(&some, &found))
            continue;
        const double far = farthest_of(all, found);
        if (far < least) {
            least = far;
            best = some;
            *centre = found;
        }
    }
    *all = best;
    return least;
}

stp_smallest_ball stp_ball_around(const vec3s *points, size_t count)
{
    support s = {.points = {stp_dvec3_from_float(points[0])}, .count = 1};
    stp_dvec3 centre = s.points[0];
    double radius = 0.0, outermost = 0.0;
    for (int pass = 0; pass < PASSES_MOST; pass++) {
        size_t far = 0;
        outermost = -1.0;
        for (size_t i = 0; i < count; i++) {
            const double d = squared(stp_dvec3_from_float(points[i]), centre);
            if (d > outermost) {
                outermost = d;
                far = i;
            }
        }
        if (outermost <= radius)
            break;
        support more = s;
        stp_dvec3 moved = centre;
        more.points[more.count++] = stp_dvec3_from_float(points[far]);
        const double grown = solve(&more, &moved);
        if (!(grown > radius)) /* only rounding is left */
            break;
        s = more;
        centre = moved;
        radius = grown;
    }
    return (stp_smallest_ball){centre, sqrt(stp_max(outermost, radius)) * (1.0 + 1e-15)};
}
