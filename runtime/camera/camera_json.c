/* Reads and writes cameras as JSON. */
#include "runtime/camera/camera_json.h"

stp_status stp_camera_read(stp_camera *camera, const cJSON *json, const char *where, stp_error *err)
{
    stp_status status = STP_OK;
    stp_camera c = *camera;
    double eye[3] = {c.eye.x, c.eye.y, c.eye.z};
    double look[3] = {c.look.x, c.look.y, c.look.z};
    double up[3] = {c.up.x, c.up.y, c.up.z};
    STP_TRY(stp_json_numbers(json, "eye", eye, 3, where, err));
    STP_TRY(stp_json_numbers(json, "look", look, 3, where, err));
    STP_TRY(stp_json_numbers(json, "up", up, 3, where, err));
    if (stp_json_has(json, "fovy_deg"))
        c.height = 0.0;
    STP_TRY(stp_json_numbers(json, "fovy_deg", &c.fovy_deg, 1, where, err));
    STP_TRY(stp_json_numbers(json, "height", &c.height, 1, where, err));
    if (c.height < 0.0)
        return stp_error_set(err, STP_FORMAT,
                             "%s: \"height\" is %g: give the height of the view, above 0", where,
                             c.height);
    c.eye = (stp_dvec3){eye[0], eye[1], eye[2]};
    c.look = (stp_dvec3){look[0], look[1], look[2]};
    c.up = (stp_dvec3){up[0], up[1], up[2]};
    *camera = c;
done:
    return status;
}

void stp_camera_write(const stp_camera *camera, cJSON *json)
{
    stp_json_add_vector(json, "eye", camera->eye);
    stp_json_add_vector(json, "look", camera->look);
    stp_json_add_vector(json, "up", camera->up);
    stp_json_add_number(json, "fovy_deg", camera->fovy_deg);
    if (camera->height > 0.0)
        stp_json_add_number(json, "height", camera->height);
}

static stp_status read_size(int out[2], const cJSON *json, const char *path, stp_error *err)
{
    double size[2] = {out[0], out[1]};
    stp_status status = stp_json_numbers(json, "size", size, 2, path, err);
    if (status != STP_OK)
        return status;
    if (!(size[0] >= 0.0 && size[0] <= 16384.0 && size[1] >= 0.0 && size[1] <= 16384.0))
        return stp_error_set(err, STP_FORMAT, "%s: \"size\" is not within 1 to 16384 pixels", path);
    out[0] = (int)size[0];
    out[1] = (int)size[1];
    return STP_OK;
}

stp_status stp_camera_load(stp_camera *camera, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_camera c = *camera;
    cJSON *json = NULL;
    STP_TRY(stp_json_load(
        &json, path, "a camera: a JSON object with eye, look, up and fovy_deg (or height)", err));
    STP_TRY(stp_camera_read(&c, json, path, err));
    STP_TRY(read_size(c.size, json, path, err));
    *camera = c;
done:
    cJSON_Delete(json);
    return status;
}
