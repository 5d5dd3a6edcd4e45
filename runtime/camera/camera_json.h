/* Reads and writes cameras as JSON, in files of cameras, paths and kept views, and in notes of
 * pictures: {"eye": [x, y, z], "look": [x, y, z], "up": [x, y, z], "fovy_deg": D, "height": H}. If
 * there is a height, the camera is orthographic. The picture's size is not included. Units: those
 * of camera.h. Threads: any. */
#ifndef STP_RUNTIME_CAMERA_CAMERA_JSON_H
#define STP_RUNTIME_CAMERA_CAMERA_JSON_H

#include "base/json.h"
#include "runtime/camera/camera.h"

/* Replaces the members that an object gives. A fovy_deg without a height makes the camera
 * perspective. where: the place that a message names. Errors: FORMAT (the message names the
 * key). */
stp_status stp_camera_read(stp_camera *camera, const cJSON *json, const char *where,
                           stp_error *err);
/* Adds the members that stp_camera_read reads to an object; numbers read back exactly. */
void stp_camera_write(const stp_camera *camera, cJSON *json);

#endif
