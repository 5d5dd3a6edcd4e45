/* Where a picture is seen from: cameras, the views derived from them, and the default view.
 *
 * World: the scan's axes and units, in double. Eye space is GL's: x right, y up, z towards the
 * viewer; depth is -z. Window coordinates: pixels, y up, pixel centres at halves.
 * Threads: any (pure functions, but for loading). */
#ifndef STP_RUNTIME_CAMERA_CAMERA_H
#define STP_RUNTIME_CAMERA_CAMERA_H

#include "base/error.h"
#include "base/vec_types.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

#define STP_CAMERA_FOVY_DEG 45.0

/* height > 0: orthographic, and so many world units fill the picture's height; else perspective. */
typedef struct stp_camera {
    stp_dvec3 eye, look, up;
    double fovy_deg;
    double height;
    int size[2]; /* of the picture in pixels; 0: not said */
} stp_camera;

/* A ball around what is looked at. */
typedef struct stp_ball {
    stp_dvec3 centre;
    double radius;
} stp_ball;

/* A camera made ready for one viewport. */
typedef struct stp_view {
    stp_dvec3 eye;
    stp_dvec3 right, up, back;  /* unit: eye space's axes in the world */
    double f;                   /* height / (2 tan(fovy / 2)); orthographic: pixels per unit */
    double near_depth;          /* what is not deeper is not drawn */
    double ball_near, ball_far; /* depths between which the model's ball lies, ball_near >= near */
    int width, height;
    bool orthographic;
    double offset[2]; /* of the camera's axis from the picture's middle, pixels; as a rule none */
    /* Where a host's matrices put a depth in normalised device coordinates: ndc[0] + ndc[1] /
     * depth, orthographic ndc[0] + ndc[1] * depth. ndc[1] is 0 where the view was made of a camera.
     */
    double ndc[2];
} stp_view;

/* The ball through the corners of a box; radius at least 1e-9 of the coordinates, and 1 where the
 * box is one point at the origin. */
stp_ball stp_ball_from_box(const stp_dbox *box);

/* Errors: INVALID_ARGUMENT (eye at look, up along the view, angle outside (0, 180), not
 * finite; an eye farther away than 1e17, an angle or a height that shows next to nothing). */
stp_status stp_view_create(stp_view *out, const stp_camera *camera, const stp_ball *ball, int width,
                           int height, stp_error *err);

/* Sets near_depth, ball_near and ball_far of a view whose eye and axes are set. */
void stp_view_set_ball(stp_view *view, const stp_ball *ball);

/* The view of a host application that draws with these matrices, columns first as GL has them, into
 * a viewport of width x height pixels. model_view takes the model's coordinates to eye space:
 * turned, shifted, scaled alike in all directions; it is where georeferenced coordinates cancel, so
 * compute it in double. projection is perspective (also with the far plane at infinity, and with
 * depth reversed) or orthographic, for any depth range: it is centred, its pixels are square, its
 * eye looks along -z. The view's lengths are the model's; the eye of an orthographic one is moved
 * back until the whole ball lies in front of it, which changes no pixel. Errors: INVALID_ARGUMENT
 * (the sentence says what in which matrix). */
stp_status stp_view_from_matrices(stp_view *out, const double model_view[16],
                                  const double projection[16], const stp_ball *ball, int width,
                                  int height, stp_error *err);

/* The up axis that a box's shape tells: z where the box is less than half as high in z as in both x
 * and y (a surveyed terrain), else y. */
stp_dvec3 stp_camera_up(const stp_dbox *box);

/* A perspective camera that sees the ball fill the smaller side of width x height from direction
 * (from the model to the eye). `up` is replaced by another axis where it is along the direction. */
stp_camera stp_camera_around(const stp_ball *ball, stp_dvec3 direction, stp_dvec3 up,
                             double fovy_deg, int width, int height);

/* The whole ball, seen from the front, a little from the right and above; up: y or z. */
stp_camera stp_camera_whole(const stp_ball *ball, stp_dvec3 up, int width, int height);
/* The same; the box says which way is up: as stp_camera_up, or z where x and y are a map's. */
stp_camera stp_camera_default(const stp_dbox *box, const stp_ball *ball, int width, int height);

/* The camera, opened so far that what it shows in a picture of the given aspect (width / height)
 * is wholly in a narrower one. */
stp_camera stp_camera_widened(const stp_camera *camera, double aspect, int width, int height);

/* Whether both see the same; the pictures' sizes do not matter. */
bool stp_camera_equal(const stp_camera *a, const stp_camera *b);

/* Replaces what a JSON file gives: eye, look, up, fovy_deg or height, size. Errors: NOT_FOUND, IO,
 * FORMAT (not such a file; the key is named). */
stp_status stp_camera_load(stp_camera *camera, const char *path, stp_error *err);

/* Window coordinates of the camera's axis. */
static inline double stp_view_axis_x(const stp_view *view)
{
    return 0.5 * view->width + view->offset[0];
}

static inline double stp_view_axis_y(const stp_view *view)
{
    return 0.5 * view->height + view->offset[1];
}

/* The view with so many times as many pixels along each side. */
stp_view stp_view_finer(const stp_view *view, int times);
/* The part of a view that begins at pixel (x, y) of it and is so large: a picture of its own, of
 * the same perspective, that may reach over the view's rim. What is drawn of both is the same. */
stp_view stp_view_part(const stp_view *view, int x, int y, int width, int height);

/* Window coordinates and depth of a world position as x, y, z; depth <= 0 is behind the eye. */
stp_dvec3 stp_view_project(const stp_view *view, stp_dvec3 position);

#ifdef __cplusplus
}
#endif

#endif
