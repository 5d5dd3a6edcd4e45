/* Computes tangents, cubics, and the rotation that a camera falls back on. */
#include "runtime/camera/path_curve.h"

#include "base/vec.h"

#define DEGREES (3.14159265358979323846 / 180.0)
/* Longest tangent, in lengths of the slower of the two segments it joins. */
#define SPEED_LIMIT 3.0
/* Shares of the distance that the rotation gives. Below FAR_LEAST the direction is the rotation's;
 * above FAR_ENOUGH it is the direction from eye to look; between, a mixture. */
#define FAR_LEAST 0.05
#define FAR_ENOUGH 0.4
/* The same for the sine of the angle between direction and up. */
#define ASIDE_LEAST 0.03
#define ASIDE_ENOUGH 0.2
/* Least distance of eye and look, as a share of the eye's coordinates: nearer, they would
 * coincide. */
#define NEAREST 1e-12
/* Limits for heights, and for tangents of half the angle; views may have any value within. */
#define HEIGHT_LIMIT 0.99e20
#define TANGENT_LEAST 5.01e-10
#define TANGENT_MOST 1e15

static const int groups[5] = {STP_CURVE_EYE, STP_CURVE_LOOK, STP_CURVE_UP, STP_CURVE_ZOOM,
                              STP_CURVE_VALUES};

static void put(double *values, stp_dvec3 v)
{
    values[0] = v.x;
    values[1] = v.y;
    values[2] = v.z;
}

static stp_dvec3 get(const double *values)
{
    return (stp_dvec3){values[0], values[1], values[2]};
}

stp_curve_knot stp_curve_knot_from_camera(const stp_camera *camera, double time_s)
{
    stp_curve_knot k = {.time_s = time_s, .orthographic = camera->height > 0.0};
    stp_dvec3 back = stp_dvec3_sub(camera->eye, camera->look);
    stp_dvec3 up = stp_dvec3_normalize(camera->up);
    k.distance = stp_dvec3_length(back);
    k.axes[2] = stp_dvec3_normalize(back);
    k.axes[0] = stp_dvec3_normalize(stp_dvec3_cross(up, k.axes[2]));
    k.axes[1] = stp_dvec3_cross(k.axes[2], k.axes[0]);
    put(k.value + STP_CURVE_EYE, camera->eye);
    put(k.value + STP_CURVE_LOOK, camera->look);
    put(k.value + STP_CURVE_UP, up);
    k.value[STP_CURVE_ZOOM] =
        k.orthographic ? log(camera->height) : log(tan(0.5 * camera->fovy_deg * DEGREES));
    return k;
}

static double slope(const stp_curve_knot *a, const stp_curve_knot *b, int i)
{
    return (b->value[i] - a->value[i]) / (b->time_s - a->time_s);
}

static double slope_length(const stp_curve_knot *a, const stp_curve_knot *b, int group)
{
    double sum = 0.0;
    for (int i = groups[group]; i < groups[group + 1]; i++)
        sum += slope(a, b, i) * slope(a, b, i);
    return sqrt(sum);
}

/* Shortens the speeds of a knot to SPEED_LIMIT times that of the slower segment. */
static void limit_speeds(stp_curve_knot *knot, int group, double slower)
{
    double sum = 0.0;
    for (int i = groups[group]; i < groups[group + 1]; i++)
        sum += knot->speed[i] * knot->speed[i];
    double length = sqrt(sum);
    for (int i = groups[group]; length > SPEED_LIMIT * slower && i < groups[group + 1]; i++)
        knot->speed[i] *= SPEED_LIMIT * slower / length;
}

/* Sets the speeds of a knot between a and b. from, to: this knot with its time next to a and next
 * to b; the two differ where a loop closes. */
static void set_inner(stp_curve_knot *of, const stp_curve_knot *a, const stp_curve_knot *from,
                      const stp_curve_knot *to, const stp_curve_knot *b)
{
    double before = from->time_s - a->time_s, after = b->time_s - to->time_s;
    for (int i = 0; i < STP_CURVE_VALUES; i++)
        of->speed[i] = (slope(a, from, i) * after + slope(to, b, i) * before) / (before + after);
    for (int g = 0; g < 4; g++)
        limit_speeds(of, g, fmin(slope_length(a, from, g), slope_length(to, b, g)));
}

/* Sets the speeds of an end knot, by the parabola that its neighbour's speed leaves. If the camera
 * would run backwards, it rests. */
static void set_end(stp_curve_knot *of, const stp_curve_knot *a, const stp_curve_knot *b,
                    const stp_curve_knot *neighbour)
{
    for (int i = 0; i < STP_CURVE_VALUES; i++)
        of->speed[i] = 2.0 * slope(a, b, i) - neighbour->speed[i];
    for (int g = 0; g < 4; g++) {
        double forward = 0.0;
        for (int i = groups[g]; i < groups[g + 1]; i++)
            forward += of->speed[i] * slope(a, b, i);
        limit_speeds(of, g, forward > 0.0 ? slope_length(a, b, g) : 0.0);
    }
}

void stp_curve_set_speeds(stp_curve_knot *knots, size_t count, bool closed)
{
    size_t last = count - 1;
    for (size_t i = 1; i < last; i++)
        set_inner(&knots[i], &knots[i - 1], &knots[i], &knots[i], &knots[i + 1]);
    if (count == 2 && !closed)
        for (int i = 0; i < STP_CURVE_VALUES; i++)
            knots[0].speed[i] = knots[1].speed[i] = slope(&knots[0], &knots[1], i);
    if (count < 3)
        return;
    if (closed) {
        set_inner(&knots[0], &knots[last - 1], &knots[last], &knots[0], &knots[1]);
        for (int i = 0; i < STP_CURVE_VALUES; i++)
            knots[last].speed[i] = knots[0].speed[i];
        return;
    }
    set_end(&knots[0], &knots[0], &knots[1], &knots[1]);
    set_end(&knots[last], &knots[last - 1], &knots[last], &knots[last - 1]);
}

/* The cubic through two knots with both speeds, computed from the nearer one, so that it is the
 * same in both directions of time. */
static double cubic(const stp_curve_knot *a, const stp_curve_knot *b, int i, double u)
{
    double span = b->time_s - a->time_s, step = b->value[i] - a->value[i];
    double v = 1.0 - u;
    double bend = span * u * v * (v * a->speed[i] - u * b->speed[i]);
    if (u <= 0.5)
        return a->value[i] + (u * u * (3.0 - 2.0 * u) * step + bend);
    return b->value[i] - (v * v * (3.0 - 2.0 * v) * step - bend);
}

static double smooth(double low, double high, double x)
{
    double t = fmin(fmax((x - low) / (high - low), 0.0), 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/* Turns unit vector a towards b by a share of the angle between them. Opposite vectors: stays a. */
static stp_dvec3 turn(stp_dvec3 a, stp_dvec3 b, double part)
{
    stp_dvec3 aside = stp_dvec3_sub(b, stp_dvec3_scale(a, stp_dvec3_dot(a, b)));
    double angle = atan2(stp_dvec3_length(aside), stp_dvec3_dot(a, b));
    aside = stp_dvec3_normalize(aside);
    return stp_dvec3_normalize(stp_dvec3_add(stp_dvec3_scale(a, cos(part * angle)),
                                             stp_dvec3_scale(aside, sin(part * angle))));
}

/* Axis and angle of the rotation from a's axes to b's. For half a turn the cross products vanish;
 * then the axis is the sum of a vector and its image. */
static double find_rotation(const stp_curve_knot *a, const stp_curve_knot *b, stp_dvec3 *axis)
{
    stp_dvec3 skew = {0.0, 0.0, 0.0}, best = {0.0, 0.0, 0.0};
    double trace = 0.0;
    for (int i = 0; i < 3; i++) {
        skew = stp_dvec3_add(skew, stp_dvec3_cross(a->axes[i], b->axes[i]));
        trace += stp_dvec3_dot(a->axes[i], b->axes[i]);
    }
    double sine = 0.5 * stp_dvec3_length(skew), cosine = 0.5 * (trace - 1.0);
    *axis = stp_dvec3_normalize(skew);
    if (sine > 1e-6)
        return atan2(sine, cosine);
    if (cosine > 0.0)
        return 0.0;
    for (int i = 0; i < 3; i++) {
        stp_dvec3 sum = stp_dvec3_add(a->axes[i], b->axes[i]);
        if (stp_dvec3_length(sum) > stp_dvec3_length(best))
            best = sum;
    }
    *axis = stp_dvec3_normalize(best);
    return 180.0 * DEGREES;
}

/* Of three vectors, the component across a direction that is longest. */
static stp_dvec3 most_across(const stp_dvec3 *vectors, stp_dvec3 direction)
{
    int best = 0;
    double most = 0.0;
    for (int i = 0; i < 3; i++) {
        double across = stp_dvec3_length(stp_dvec3_cross(vectors[i], direction));
        if (across > most + 1e-9) {
            most = across;
            best = i;
        }
    }
    return vectors[best];
}

/* The up vector of a camera that looks against `back`. rotated: the axes that the rotation
 * gives. */
static stp_dvec3 choose_up(stp_dvec3 up, stp_dvec3 back, const stp_dvec3 rotated[3])
{
    double part = smooth(ASIDE_LEAST, ASIDE_ENOUGH, stp_dvec3_length(stp_dvec3_cross(up, back)));
    if (part >= 1.0)
        return up;
    up = part > 0.0 ? turn(rotated[1], stp_dvec3_normalize(up), part) : rotated[1];
    if (stp_dvec3_length(stp_dvec3_cross(up, back)) > 0.5 * ASIDE_LEAST)
        return up;
    const stp_dvec3 others[3] = {rotated[1], rotated[2], rotated[0]};
    return most_across(others, back);
}

/* Sets height or angle from the value of the curve. */
static void set_zoom(stp_camera *camera, double value, bool orthographic)
{
    const double zoom = exp(value);
    if (orthographic)
        camera->height = fmin(fmax(zoom, 1.0 / HEIGHT_LIMIT), HEIGHT_LIMIT);
    else
        camera->fovy_deg = 2.0 * atan(fmin(fmax(zoom, TANGENT_LEAST), TANGENT_MOST)) / DEGREES;
}

stp_camera stp_curve_camera(const stp_curve_knot *a, const stp_curve_knot *b, double time_s)
{
    double value[STP_CURVE_VALUES], u = (time_s - a->time_s) / (b->time_s - a->time_s);
    for (int i = 0; i < STP_CURVE_VALUES; i++)
        value[i] = cubic(a, b, i, u);
    stp_dvec3 axis, rotated[3];
    double angle = find_rotation(a, b, &axis);
    for (int i = 0; i < 3; i++)
        rotated[i] = stp_dvec3_rotate(a->axes[i], axis, u * angle);
    stp_camera camera = {.eye = get(value + STP_CURVE_EYE), .look = get(value + STP_CURVE_LOOK)};
    stp_dvec3 offset = stp_dvec3_sub(camera.eye, camera.look);
    double length = stp_dvec3_length(offset);
    double distance = exp((1.0 - u) * log(a->distance) + u * log(b->distance));
    double part = smooth(FAR_LEAST, FAR_ENOUGH, length / distance);
    stp_dvec3 back = stp_dvec3_normalize(offset);
    if (part < 1.0) {
        back = part > 0.0 ? turn(rotated[2], back, part) : rotated[2];
        distance += part * (length - distance);
        distance = fmax(distance, NEAREST * stp_dvec3_reach(camera.eye));
        camera.look = stp_dvec3_sub(camera.eye, stp_dvec3_scale(back, distance));
    }
    camera.up = choose_up(get(value + STP_CURVE_UP), back, rotated);
    set_zoom(&camera, value[STP_CURVE_ZOOM], a->orthographic);
    return camera;
}
