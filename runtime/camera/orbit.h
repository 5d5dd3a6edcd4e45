/* Moves a camera by hand: turns it about a point, shifts it, brings it nearer to a point.
 *
 * Angles in radians, lengths in world units, window coordinates in pixels, y up. The point under
 * the cursor stays under the cursor. Threads: any (pure functions). */
#ifndef STP_RUNTIME_CAMERA_ORBIT_H
#define STP_RUNTIME_CAMERA_ORBIT_H

#include "base/vec.h"
#include "runtime/camera/camera.h"

/* How near the eye may come to a point, and how far from the ball it may go, in radii of the
 * ball. */
#define STP_ORBIT_NEAREST 1e-4
#define STP_ORBIT_FARTHEST 100.0
/* Least angle between the view and the up axis. */
#define STP_ORBIT_POLE_RAD 0.01

/* The world position that a view shows at window coordinates (u, v) and a depth: the inverse of
 * stp_view_project. */
stp_dvec3 stp_view_unproject(const stp_view *view, double u, double v, double depth);

/* Turns the eye about a point: by yaw about the camera's up axis, then by pitch about the picture's
 * x axis, but never over a pole. As seen, a positive yaw turns the near side of the model to the
 * right, a positive pitch turns it down. */
void stp_camera_turn(stp_camera *camera, stp_dvec3 pivot, double yaw_rad, double pitch_rad);

/* Shifts the camera so that points at `depth` move by (dx, dy) pixels in a picture of `height`
 * pixels. */
void stp_camera_pan(stp_camera *camera, double depth, double dx, double dy, int height);

/* Scales the distance to a point (orthographic: the height of the picture) by a factor > 0. The
 * point keeps its place in the picture. Stops at STP_ORBIT_NEAREST and STP_ORBIT_FARTHEST. */
void stp_camera_zoom(stp_camera *camera, const stp_ball *ball, stp_dvec3 point, double factor);

#endif
