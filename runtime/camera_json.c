/* Cameras as JSON: eye look up fovy_deg (or height, orthographic) and size. */
#include "runtime/camera.h"

#include "base/vec.h"

#include "base/file.h"
#include "base/memory.h"

#include <cjson/cJSON.h>
#include <stdlib.h>
#include <unistd.h>

#define FILE_BYTES_LIMIT (1u << 20)

static stp_status read_numbers(const cJSON *json, const char *key, double *out, int count,
                               const char *path, stp_error *err)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, key);
    if (item == NULL)
        return STP_OK;
    bool good = count == 1 ? cJSON_IsNumber(item)
                           : cJSON_IsArray(item) && cJSON_GetArraySize(item) == count;
    double values[3] = {0.0, 0.0, 0.0};
    for (int i = 0; good && i < count; i++) {
        const cJSON *number = count == 1 ? item : cJSON_GetArrayItem(item, i);
        good = cJSON_IsNumber(number) && isfinite(number->valuedouble);
        values[i] = good ? number->valuedouble : 0.0;
    }
    if (!good)
        return stp_error_set(err, STP_FORMAT, "%s: \"%s\" is not %d number%s", path, key, count,
                             count == 1 ? "" : "s");
    for (int i = 0; i < count; i++)
        out[i] = values[i];
    return STP_OK;
}

static stp_status read_camera(stp_camera *camera, const cJSON *json, const char *path,
                              stp_error *err)
{
    stp_status status = STP_OK;
    stp_camera c = *camera;
    double eye[3] = {c.eye.x, c.eye.y, c.eye.z};
    double look[3] = {c.look.x, c.look.y, c.look.z};
    double up[3] = {c.up.x, c.up.y, c.up.z};
    double size[2] = {c.size[0], c.size[1]};
    STP_TRY(read_numbers(json, "eye", eye, 3, path, err));
    STP_TRY(read_numbers(json, "look", look, 3, path, err));
    STP_TRY(read_numbers(json, "up", up, 3, path, err));
    STP_TRY(read_numbers(json, "fovy_deg", &c.fovy_deg, 1, path, err));
    STP_TRY(read_numbers(json, "height", &c.height, 1, path, err));
    STP_TRY(read_numbers(json, "size", size, 2, path, err));
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
    stp_status status = STP_OK;
    int descriptor = -1;
    uint64_t size = 0;
    char *text = NULL;
    cJSON *json = NULL;
    STP_TRY(stp_file_open(path, &descriptor, &size, err));
    if (size > FILE_BYTES_LIMIT) {
        status = stp_error_set(err, STP_FORMAT, "%s: too large for a camera (over 1 MiB)", path);
        goto done;
    }
    STP_TRY(stp_alloc(&text, (size_t)size + 1, 1, "a camera", err));
    STP_TRY(stp_file_read_at(descriptor, path, 0, text, (size_t)size, err));
    json = cJSON_ParseWithLength(text, (size_t)size);
    if (!cJSON_IsObject(json)) {
        status = stp_error_set(err, STP_FORMAT,
                               "%s: not a camera: a JSON object with eye, look, up and fovy_deg "
                               "(or height) is expected",
                               path);
        goto done;
    }
    STP_TRY(read_camera(camera, json, path, err));
done:
    cJSON_Delete(json);
    free(text);
    if (descriptor >= 0)
        close(descriptor);
    return status;
}
