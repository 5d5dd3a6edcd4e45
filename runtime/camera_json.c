/* Cameras as JSON: eye look up fovy_deg (or height, orthographic) and size. */
#include "runtime/camera.h"

#include "base/vec.h"
#include "runtime/json.h"

static stp_status read_camera(stp_camera *camera, const cJSON *json, const char *path,
                              stp_error *err)
{
    stp_status status = STP_OK;
    stp_camera c = *camera;
    double eye[3] = {c.eye.x, c.eye.y, c.eye.z};
    double look[3] = {c.look.x, c.look.y, c.look.z};
    double up[3] = {c.up.x, c.up.y, c.up.z};
    double size[2] = {c.size[0], c.size[1]};
    STP_TRY(stp_json_numbers(json, "eye", eye, 3, path, err));
    STP_TRY(stp_json_numbers(json, "look", look, 3, path, err));
    STP_TRY(stp_json_numbers(json, "up", up, 3, path, err));
    STP_TRY(stp_json_numbers(json, "fovy_deg", &c.fovy_deg, 1, path, err));
    STP_TRY(stp_json_numbers(json, "height", &c.height, 1, path, err));
    STP_TRY(stp_json_numbers(json, "size", size, 2, path, err));
    if (!(size[0] >= 0.0 && size[0] <= 16384.0 && size[1] >= 0.0 && size[1] <= 16384.0))
        return stp_error_set(err, STP_FORMAT, "%s: \"size\" is not within 1 to 16384 pixels", path);
    c.eye = (stp_dvec3){eye[0], eye[1], eye[2]};
    c.look = (stp_dvec3){look[0], look[1], look[2]};
    c.up = (stp_dvec3){up[0], up[1], up[2]};
    c.size[0] = (int)size[0];
    c.size[1] = (int)size[1];
    *camera = c;
done:
    return status;
}

stp_status stp_camera_load(stp_camera *camera, const char *path, stp_error *err)
{
    cJSON *json = NULL;
    stp_status status = stp_json_load(
        &json, path, "a camera: a JSON object with eye, look, up and fovy_deg (or height)", err);
    if (status == STP_OK)
        status = read_camera(camera, json, path, err);
    cJSON_Delete(json);
    return status;
}
