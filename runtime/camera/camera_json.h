/* Cameras as JSON, in files of cameras, of paths and of kept views and in notes of pictures:
 * {"eye": [x, y, z], "look": [x, y, z], "up": [x, y, z], "fovy_deg": D, "height": H}; orthographic
 * where there is a height. The picture's size is no part of it. Units: those of camera.h. Threads:
 * any. */
#ifndef STP_RUNTIME_CAMERA_CAMERA_JSON_H
#define STP_RUNTIME_CAMERA_CAMERA_JSON_H

#include "base/json.h"
#include "runtime/camera/camera.h"

/* Replaces what an object says; a fovy_deg without a height makes the camera perspective. where: of
 * the message. Errors: FORMAT (the key is named). */
stp_status stp_camera_read(stp_camera *camera, const cJSON *json, const char *where,
                           stp_error *err);
/* Adds what stp_camera_read reads to an object; numbers come back as they were. */
void stp_camera_write(const stp_camera *camera, cJSON *json);

#endif
