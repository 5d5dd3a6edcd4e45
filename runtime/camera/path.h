/* Camera paths: keyframes that a camera passes through in time, or a turn about what it looks at.
 *
 * Between keyframes eye, look and up go along cubic Hermite curves through all of them, with the
 * tangents of Catmull and Rom (1974) for the times given: those of the parabola through a keyframe
 * and its neighbours, so that uneven times do not jerk. No tangent is longer than 3 times the
 * slower of the two segments it joins (the bound of Fritsch and Carlson 1980): a camera that rests
 * between two equal keyframes rests, and nothing swings far past a keyframe. The angle of view goes
 * by the logarithm of its tangent, a height by its own. A point looked at from all keyframes stays
 * looked at.
 *
 * Where the curves would let the eye meet what it looks at, or the view point along up, direction
 * and up go over, smoothly, to those of a rotation (Shoemake 1985) between the keyframes, so a
 * camera between valid ones is valid.
 *
 * Units: seconds, degrees, the world's units. Coordinates reach 1e16, and an eye is 1e-12 of them
 * or more from what it looks at: then views stay valid between keyframes. Only differences of
 * coordinates are computed with. Times lie within 1e9 s of 0, 1e-6 s or more apart. Ownership:
 * create, load and destroy in pairs. Threads: any (read-only once made). */
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
    const stp_keyframe *keyframes; /* times rise; copied */
    size_t count;
    bool loop;     /* from the last one back to the first */
    double loop_s; /* of one round; 0: as long as the last keyframe repeats the first, or where it
                      does not, with a way back as long as the mean of the others */
} stp_path_params;

typedef struct stp_turntable {
    double seconds;
    double degrees;       /* counter-clockwise, seen from above; 0: 360 */
    double elevation_deg; /* of the eye above what it looks at */
    bool has_elevation;   /* else as the camera has it */
} stp_turntable;

typedef struct stp_path stp_path;

/* Errors: EMPTY (no keyframe), INVALID_ARGUMENT (times that do not rise, a camera that
 * stp_view_create would refuse or that is out of the range above, perspective and orthographic ones
 * mixed; the keyframe is named), LIMIT, OUT_OF_MEMORY. */
stp_status stp_path_create(stp_path **out, const stp_path_params *params, stp_error *err);
/* Turns a camera about the axis that points up through what it looks at. Errors: INVALID_ARGUMENT,
 * OUT_OF_MEMORY. */
stp_status stp_path_create_turntable(stp_path **out, const stp_turntable *turntable,
                                     const stp_camera *start, stp_error *err);
void stp_path_destroy(stp_path **path);

/* Reads {"keyframes": [{"time": S, "eye": [x, y, z], "look": [x, y, z], "up": [x, y, z],
 * "fovy_deg": D or "height": H}, ...], "loop": false, "loop_seconds": S} or {"turntable":
 * {"seconds": S, "degrees": D, "elevation_deg": D}}. What a keyframe leaves out but time, eye and
 * look is that of the one before, at first that of base; a turntable turns base. Errors: NOT_FOUND,
 * IO, FORMAT (the key is named) and those of creating it, all with the file's name. */
stp_status stp_path_load(stp_path **out, const char *file, const stp_camera *base, stp_error *err);
/* Writes what stp_path_load reads; numbers come back as they were. The file appears whole or not at
 * all. Errors: EXISTS (without force), IO, OUT_OF_MEMORY. */
stp_status stp_path_save(const stp_path_params *params, const char *file, bool force,
                         stp_error *err);

/* Time of the first keyframe (a turntable: 0) and from there to the end. */
double stp_path_begin_s(const stp_path *path);
double stp_path_duration_s(const stp_path *path);
/* The end is the beginning: a loop, or a turntable of whole turns. */
bool stp_path_loops(const stp_path *path);

/* The camera at a time: at a keyframe's exactly that one's, before the first and after the last
 * theirs; a loop goes on and on. */
stp_camera stp_path_camera(const stp_path *path, double time_s);

/* Frames of a film of so many a second. One that loops ends a frame before its beginning, any other
 * with the first frame that is not before its end. Errors: INVALID_ARGUMENT (rate is not above 0),
 * LIMIT (over STP_PATH_FRAMES_LIMIT). */
stp_status stp_path_frame_count(const stp_path *path, double rate, uint64_t *count, stp_error *err);
/* The camera of frame index out of count, of that many a second. */
stp_camera stp_path_frame(const stp_path *path, double rate, uint64_t count, uint64_t index);

#endif
