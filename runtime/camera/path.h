/* Camera paths: a camera passes through keyframes in time, or turns about the point it looks at.
 *
 * Between keyframes, eye, look and up follow cubic Hermite curves through all keyframes. The
 * tangents are those of Catmull and Rom (1974) for the given times: the tangent of the parabola
 * through a keyframe and its two neighbours, so uneven times do not jerk. A tangent is at most 3
 * times as fast as the slower of the two segments that it joins (the bound of Fritsch and Carlson
 * 1980). So a camera rests between two equal keyframes, and does not swing far past a keyframe. The
 * angle of view is interpolated as log(tan(fovy / 2)), the height as log(height). If all keyframes
 * look at the same point, the camera looks at that point all the time.
 *
 * If the curves would bring the eye to the point it looks at, or turn the view along up, then
 * direction and up change over smoothly to a rotation between the keyframes (Shoemake 1985). So a
 * camera between valid keyframes is valid.
 *
 * Units: seconds, degrees, the world's units. Coordinates reach 1e16. The eye is at least 1e-12 of
 * the coordinates away from the point it looks at; this keeps views valid between keyframes. The
 * curves only compute with differences of coordinates. Times lie within 1e9 s of 0 and at least
 * 1e-6 s apart. Ownership: call create (or load) and destroy in pairs. Threads: any (read-only
 * once made). */
#ifndef STP_RUNTIME_CAMERA_PATH_H
#define STP_RUNTIME_CAMERA_PATH_H

#include "runtime/camera/camera.h"

#include <stddef.h>
#include <stdint.h>

#define STP_PATH_KEYFRAMES_LIMIT 100000u
#define STP_PATH_FRAMES_LIMIT 9999999u

typedef struct stp_keyframe {
    double time_s;
    stp_camera camera; /* its size is not used */
} stp_keyframe;

typedef struct stp_path_params {
    const stp_keyframe *keyframes; /* in order of rising times; copied */
    size_t count;
    bool loop;     /* goes from the last keyframe back to the first */
    double loop_s; /* duration of one round. 0: up to the last keyframe if that repeats the first;
                      otherwise plus a way back that takes the mean time of the other segments */
} stp_path_params;

typedef struct stp_turntable {
    double seconds;
    double degrees;       /* counter-clockwise, seen from above; 0: 360 */
    double elevation_deg; /* of the eye above the point it looks at */
    bool has_elevation;   /* false: the camera's own elevation */
} stp_turntable;

typedef struct stp_path stp_path;

/* Errors: EMPTY (no keyframe), INVALID_ARGUMENT (times that do not rise; a camera that
 * stp_view_create would refuse, or that is out of the range above; perspective mixed with
 * orthographic; the message names the keyframe), LIMIT, OUT_OF_MEMORY. */
stp_status stp_path_create(stp_path **out, const stp_path_params *params, stp_error *err);
/* Turns a camera about the vertical axis through the point it looks at. Errors: INVALID_ARGUMENT,
 * OUT_OF_MEMORY. */
stp_status stp_path_create_turntable(stp_path **out, const stp_turntable *turntable,
                                     const stp_camera *start, stp_error *err);
void stp_path_destroy(stp_path **path);

/* Reads {"keyframes": [{"time": S, "eye": [x, y, z], "look": [x, y, z], "up": [x, y, z],
 * "fovy_deg": D or "height": H}, ...], "loop": false, "loop_seconds": S} or {"turntable":
 * {"seconds": S, "degrees": D, "elevation_deg": D}}. A keyframe must give time, eye and look. It
 * takes other members from the keyframe before; the first takes them from `base`. A turntable turns
 * `base`. Errors: NOT_FOUND, IO, FORMAT (the message names the key) and those of creating the path,
 * all with the file's name. */
stp_status stp_path_load(stp_path **out, const char *file, const stp_camera *base, stp_error *err);
/* Writes a file for stp_path_load; numbers read back exactly. The file appears whole or not at all.
 * Errors: EXISTS (without force), IO, OUT_OF_MEMORY. */
stp_status stp_path_save(const stp_path_params *params, const char *file, bool force,
                         stp_error *err);

/* Time of the first keyframe (turntable: 0), and the time from there to the end. */
double stp_path_begin_s(const stp_path *path);
double stp_path_duration_s(const stp_path *path);

/* The camera at a time. At a keyframe's time exactly the keyframe's camera. Before the first and
 * after the last keyframe, the camera stays; a loop repeats. */
stp_camera stp_path_camera(const stp_path *path, double time_s);

/* The number of frames in a film of `rate` frames a second. The film of a loop ends one frame
 * before its beginning repeats. Any other film ends with the first frame at or after the path's
 * end. Errors: INVALID_ARGUMENT (rate not above 0), LIMIT (over STP_PATH_FRAMES_LIMIT). */
stp_status stp_path_frame_count(const stp_path *path, double rate, uint64_t *count, stp_error *err);
/* The camera of frame `index` of `count`, at `rate` frames a second. */
stp_camera stp_path_frame(const stp_path *path, double rate, uint64_t count, uint64_t index);

#endif
