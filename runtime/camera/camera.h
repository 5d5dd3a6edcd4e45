/* Cameras, the views derived from them, and the default view.
 *
 * World: the scan's axes and units, in double. Eye space is GL's: x right, y up, z towards the
 * viewer; depth is -z. Window coordinates: pixels, y up, pixel centres at halves.
 * Threads: any (pure functions, except for loading). */
#ifndef STP_RUNTIME_CAMERA_CAMERA_H
#define STP_RUNTIME_CAMERA_CAMERA_H

#include "base/error.h"
#include "base/vec_types.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

#define STP_CAMERA_FOVY_DEG 45.0

/* height > 0: orthographic, and the picture is `height` world units high. Otherwise perspective. */
typedef struct stp_camera {
    stp_dvec3 eye, look, up;
    double fovy_deg;
    double height;
    int size[2]; /* of the picture in pixels; 0: not given */
} stp_camera;

/* A ball around a model. */
typedef struct stp_ball {
    stp_dvec3 centre;
    double radius;
} stp_ball;

/* A camera made ready for one viewport. */
typedef struct stp_view {
    stp_dvec3 eye;
    stp_dvec3 right, up, back;  /* unit: eye space's axes in the world */
    double f;                   /* height / (2 tan(fovy / 2)); orthographic: pixels per unit */
    double near_depth;          /* nothing at this depth or nearer is drawn */
    double ball_near, ball_far; /* the model's ball lies between these depths; ball_near >= near */
    int width, height;
    bool orthographic;
    double offset[2]; /* of the camera's axis from the picture's middle, pixels; mostly 0 */
    /* How a host's matrices map depth to normalised device coordinates: ndc[0] + ndc[1] / depth;
     * orthographic: ndc[0] + ndc[1] * depth. ndc[1] is 0 if the view was made from a camera. */
    double ndc[2];
} stp_view;

/* The ball through the corners of a box. The radius is at least 1e-9 of the coordinates, and 1 if
 * the box is a single point at the origin. */
stp_ball stp_ball_from_box(const stp_dbox *box);

/* Errors: INVALID_ARGUMENT (eye at look; up along the view; angle outside (0, 180); a value not
 * finite; an eye farther than 1e17; an angle or a height that shows next to nothing). */
stp_status stp_view_create(stp_view *out, const stp_camera *camera, const stp_ball *ball, int width,
                           int height, stp_error *err);

/* Sets near_depth, ball_near and ball_far of a view whose eye and axes are set. */
void stp_view_set_ball(stp_view *view, const stp_ball *ball);

/* The view of a host application that draws with these matrices, column by column as in GL, into a
 * viewport of width x height pixels.
 * model_view takes the model's coordinates to eye space by rotation, translation and uniform scale.
 * Large georeferenced coordinates cancel in model_view, so compute it in double.
 * projection is perspective (the far plane may be infinite, depth may be reversed) or orthographic,
 * with any depth range. It must be centred, with square pixels, and look along -z.
 * Lengths of the view are the model's. The eye of an orthographic view moves back until the whole
 * ball lies in front of it; this changes no pixel. Errors: INVALID_ARGUMENT (the message says what
 * is wrong in which matrix). */
stp_status stp_view_from_matrices(stp_view *out, const double model_view[16],
                                  const double projection[16], const stp_ball *ball, int width,
                                  int height, stp_error *err);

/* The up axis, guessed from a box's shape: z if the box is less than half as high in z as in both x
 * and y (a surveyed terrain), else y. */
stp_dvec3 stp_camera_up(const stp_dbox *box);

/* A perspective camera in `direction` from the model. The ball fills the smaller side of width x
 * height. If `up` is along the direction, another axis replaces `up`. */
stp_camera stp_camera_around(const stp_ball *ball, stp_dvec3 direction, stp_dvec3 up,
                             double fovy_deg, int width, int height);

/* The whole ball, seen from the front, a little from the right and above. up: y or z. */
stp_camera stp_camera_whole(const stp_ball *ball, stp_dvec3 up, int width, int height);
/* stp_camera_whole with `up` from the box: by stp_camera_up, or z if x and y are map
 * coordinates. */
stp_camera stp_camera_default(const stp_dbox *box, const stp_ball *ball, int width, int height);

/* The camera, opened until a narrower picture of width x height shows everything that the camera
 * shows in a picture of the given aspect (width / height). */
stp_camera stp_camera_widened(const stp_camera *camera, double aspect, int width, int height);

/* Whether both cameras see the same; the sizes of their pictures do not matter. */
bool stp_camera_equal(const stp_camera *a, const stp_camera *b);

/* Replaces the members that a JSON file gives: eye, look, up, fovy_deg or height, size. Errors:
 * NOT_FOUND, IO, FORMAT (not a camera file; the message names the key). */
stp_status stp_camera_load(stp_camera *camera, const char *path, stp_error *err);

/* Window coordinates of the point where the camera's axis meets the picture. */
static inline double stp_view_axis_x(const stp_view *view)
{
    return 0.5 * view->width + view->offset[0];
}

static inline double stp_view_axis_y(const stp_view *view)
{
    return 0.5 * view->height + view->offset[1];
}

/* The same view with `times` as many pixels along each side, rounded; at least 1. */
stp_view stp_view_scaled(const stp_view *view, double times);
/* The part of a view of this size that begins at pixel (x, y): a picture of its own in the same
 * perspective. It may reach over the view's rim. Where the two overlap, they show the same. */
stp_view stp_view_part(const stp_view *view, int x, int y, int width, int height);

/* Projects a world position: x, y in window coordinates, z the depth; depth <= 0: behind the
 * eye. */
stp_dvec3 stp_view_project(const stp_view *view, stp_dvec3 position);

#ifdef __cplusplus
}
#endif

#endif
