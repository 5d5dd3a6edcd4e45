/* Reads and writes paths as JSON. */
#include "runtime/camera/path.h"

#include "base/memory.h"
#include "runtime/camera/camera_json.h"

#include <stdio.h>
#include <stdlib.h>

#define KEY_NAME_BYTES 512

/* Reads the members that a keyframe gives; other members of *key stay. */
static stp_status read_keyframe(stp_keyframe *key, const cJSON *json, const char *where,
                                stp_error *err)
{
    static const char *const needed[3] = {"time", "eye", "look"};
    stp_status status = STP_OK;
    if (!cJSON_IsObject(json))
        return stp_error_set(err, STP_FORMAT, "%s is not an object with time, eye and look", where);
    for (int i = 0; i < 3; i++)
        if (!stp_json_has(json, needed[i]))
            return stp_error_set(err, STP_FORMAT, "%s: \"%s\" is missing", where, needed[i]);
    STP_TRY(stp_json_numbers(json, "time", &key->time_s, 1, where, err));
    STP_TRY(stp_camera_read(&key->camera, json, where, err));
done:
    return status;
}

static stp_status read_loop(stp_path_params *params, const cJSON *json, const char *file,
                            stp_error *err)
{
    const cJSON *loop = cJSON_GetObjectItemCaseSensitive(json, "loop");
    if (loop != NULL && !cJSON_IsBool(loop))
        return stp_error_set(err, STP_FORMAT, "%s: \"loop\" is not true or false", file);
    params->loop = cJSON_IsTrue(loop);
    return stp_json_numbers(json, "loop_seconds", &params->loop_s, 1, file, err);
}

/* Puts the file's name before the reason of an error. */
static stp_status name_file(stp_status status, const char *file, const stp_error *reason,
                            stp_error *err)
{
    return status == STP_OK ? STP_OK
                            : stp_error_set(err, status, "%.400s: %.500s", file, reason->message);
}

static stp_status load_keyframes(stp_path **out, const cJSON *json, const cJSON *list,
                                 const char *file, const stp_camera *base, stp_error *err)
{
    stp_status status = STP_OK;
    stp_error reason = {0};
    stp_keyframe *keys = NULL;
    stp_keyframe key = {.camera = *base};
    stp_path_params params = {0};
    const cJSON *item = NULL;
    if (!cJSON_IsArray(list))
        return stp_error_set(err, STP_FORMAT, "%s: \"keyframes\" is not a list", file);
    STP_TRY(read_loop(&params, json, file, err));
    STP_TRY(stp_alloc(&keys, (size_t)cJSON_GetArraySize(list), sizeof *keys, "keyframes", err));
    cJSON_ArrayForEach(item, list)
    {
        char where[KEY_NAME_BYTES];
        snprintf(where, sizeof where, "%.400s: keyframe %zu", file, params.count + 1);
        STP_TRY(read_keyframe(&key, item, where, err));
        keys[params.count++] = key;
    }
    params.keyframes = keys;
    status = name_file(stp_path_create(out, &params, &reason), file, &reason, err);
done:
    free(keys);
    return status;
}

static stp_status load_turntable(stp_path **out, const cJSON *json, const char *file,
                                 const stp_camera *base, stp_error *err)
{
    stp_status status = STP_OK;
    stp_error reason = {0};
    stp_turntable turntable = {0};
    if (!cJSON_IsObject(json))
        return stp_error_set(err, STP_FORMAT, "%s: \"turntable\" is not an object with seconds",
                             file);
    if (!stp_json_has(json, "seconds"))
        return stp_error_set(err, STP_FORMAT, "%s: the turntable's \"seconds\" is missing", file);
    STP_TRY(stp_json_numbers(json, "seconds", &turntable.seconds, 1, file, err));
    STP_TRY(stp_json_numbers(json, "degrees", &turntable.degrees, 1, file, err));
    STP_TRY(stp_json_numbers(json, "elevation_deg", &turntable.elevation_deg, 1, file, err));
    turntable.has_elevation = stp_json_has(json, "elevation_deg");
    status =
        name_file(stp_path_create_turntable(out, &turntable, base, &reason), file, &reason, err);
done:
    return status;
}

stp_status stp_path_load(stp_path **out, const char *file, const stp_camera *base, stp_error *err)
{
    static const char expected[] = "a path: a JSON object with keyframes or a turntable";
    cJSON *json = NULL;
    stp_status status = stp_json_load(&json, file, expected, err);
    if (status != STP_OK)
        return status;
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(json, "keyframes");
    const cJSON *turntable = cJSON_GetObjectItemCaseSensitive(json, "turntable");
    if ((list != NULL) == (turntable != NULL))
        status = stp_error_set(err, STP_FORMAT, "%s: not %s%s", file, expected,
                               list != NULL ? ", but with both" : "");
    else if (list != NULL)
        status = load_keyframes(out, json, list, file, base, err);
    else
        status = load_turntable(out, turntable, file, base, err);
    cJSON_Delete(json);
    return status;
}

/* The path as JSON; NULL if memory is exhausted. */
static cJSON *path_json(const stp_path_params *params)
{
    cJSON *json = cJSON_CreateObject();
    cJSON *list = cJSON_AddArrayToObject(json, "keyframes");
    for (size_t i = 0; i < params->count && list != NULL; i++) {
        cJSON *key = cJSON_CreateObject();
        stp_json_add_number(key, "time", params->keyframes[i].time_s);
        stp_camera_write(&params->keyframes[i].camera, key);
        cJSON_AddItemToArray(list, key);
    }
    cJSON_AddBoolToObject(json, "loop", params->loop);
    if (params->loop_s > 0.0)
        stp_json_add_number(json, "loop_seconds", params->loop_s);
    return json;
}

stp_status stp_path_save(const stp_path_params *params, const char *file, bool force,
                         stp_error *err)
{
    return stp_json_save(path_json(params), file, force, err);
}
