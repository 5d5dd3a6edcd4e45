/* The curve between two keyframes of a path; path.h describes the method.
 * Threads: any (pure functions). */
#ifndef STP_RUNTIME_CAMERA_PATH_CURVE_H
#define STP_RUNTIME_CAMERA_PATH_CURVE_H

#include "runtime/camera/camera.h"

#include <stddef.h>

enum { STP_CURVE_EYE = 0, STP_CURVE_LOOK = 3, STP_CURVE_UP = 6, STP_CURVE_ZOOM = 9 };
#define STP_CURVE_VALUES 10

typedef struct stp_curve_knot {
    double time_s;
    double value[STP_CURVE_VALUES]; /* eye, look, unit up, ln(tan(fovy / 2)) or ln(height) */
    double speed[STP_CURVE_VALUES]; /* derivatives of `value` here, per second */
    stp_dvec3 axes[3];              /* right, up, back: unit */
    double distance;                /* from eye to look */
    bool orthographic;
} stp_curve_knot;

/* The knot of a valid camera; its speeds are zero. */
stp_curve_knot stp_curve_knot_from_camera(const stp_camera *camera, double time_s);
/* closed: the last knot is the first. */
void stp_curve_set_speeds(stp_curve_knot *knots, size_t count, bool closed);
/* The camera at a time strictly between the times of two neighbouring knots. */
stp_camera stp_curve_camera(const stp_curve_knot *a, const stp_curve_knot *b, double time_s);

#endif
