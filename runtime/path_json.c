/* Paths as JSON. */
#include "runtime/path.h"

#include "base/file.h"
#include "base/memory.h"
#include "runtime/json.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define KEY_NAME_BYTES 512

static bool has(const cJSON *json, const char *key)
{
    return cJSON_GetObjectItemCaseSensitive(json, key) != NULL;
}

/* What a keyframe says; the rest stays as it is in *key. */
static stp_status read_keyframe(stp_keyframe *key, const cJSON *json, const char *where,
                                stp_error *err)
{
    static const char *const needed[3] = {"time", "eye", "look"};
    stp_status status = STP_OK;
    stp_camera *c = &key->camera;
    double vectors[3][3] = {{0.0}, {0.0}, {c->up.x, c->up.y, c->up.z}};
    if (!cJSON_IsObject(json))
        return stp_error_set(err, STP_FORMAT, "%s is not an object with time, eye and look", where);
    for (int i = 0; i < 3; i++)
        if (!has(json, needed[i]))
            return stp_error_set(err, STP_FORMAT, "%s: \"%s\" is missing", where, needed[i]);
    STP_TRY(stp_json_numbers(json, "time", &key->time_s, 1, where, err));
    STP_TRY(stp_json_numbers(json, "eye", vectors[0], 3, where, err));
    STP_TRY(stp_json_numbers(json, "look", vectors[1], 3, where, err));
    STP_TRY(stp_json_numbers(json, "up", vectors[2], 3, where, err));
    if (has(json, "fovy_deg"))
        c->height = 0.0;
    STP_TRY(stp_json_numbers(json, "fovy_deg", &c->fovy_deg, 1, where, err));
    STP_TRY(stp_json_numbers(json, "height", &c->height, 1, where, err));
    c->eye = (stp_dvec3){vectors[0][0], vectors[0][1], vectors[0][2]};
    c->look = (stp_dvec3){vectors[1][0], vectors[1][1], vectors[1][2]};
    c->up = (stp_dvec3){vectors[2][0], vectors[2][1], vectors[2][2]};
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

/* Names the file in front of what went wrong. */
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
    if (!has(json, "seconds"))
        return stp_error_set(err, STP_FORMAT, "%s: the turntable's \"seconds\" is missing", file);
    STP_TRY(stp_json_numbers(json, "seconds", &turntable.seconds, 1, file, err));
    STP_TRY(stp_json_numbers(json, "degrees", &turntable.degrees, 1, file, err));
    STP_TRY(stp_json_numbers(json, "elevation_deg", &turntable.elevation_deg, 1, file, err));
    turntable.has_elevation = has(json, "elevation_deg");
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

/* All digits: cJSON prints 15 where that is nearly the number. */
static void add_number(cJSON *object, const char *name, double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.17g", value);
    cJSON_AddRawToObject(object, name, text);
}

static void add_vector(cJSON *object, const char *name, stp_dvec3 v)
{
    char text[96];
    snprintf(text, sizeof text, "[%.17g, %.17g, %.17g]", v.x, v.y, v.z);
    cJSON_AddRawToObject(object, name, text);
}

/* NULL where memory is exhausted. */
static cJSON *path_json(const stp_path_params *params)
{
    cJSON *json = cJSON_CreateObject();
    cJSON *list = cJSON_AddArrayToObject(json, "keyframes");
    for (size_t i = 0; i < params->count && list != NULL; i++) {
        const stp_camera *c = &params->keyframes[i].camera;
        cJSON *key = cJSON_CreateObject();
        add_number(key, "time", params->keyframes[i].time_s);
        add_vector(key, "eye", c->eye);
        add_vector(key, "look", c->look);
        add_vector(key, "up", c->up);
        if (c->height > 0.0)
            add_number(key, "height", c->height);
        else
            add_number(key, "fovy_deg", c->fovy_deg);
        cJSON_AddItemToArray(list, key);
    }
    cJSON_AddBoolToObject(json, "loop", params->loop);
    if (params->loop_s > 0.0)
        add_number(json, "loop_seconds", params->loop_s);
    return json;
}

stp_status stp_path_save(const stp_path_params *params, const char *file, bool force,
                         stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *output = NULL;
    cJSON *json = path_json(params);
    char *text = json != NULL ? cJSON_PrintBuffered(json, 4096, true) : NULL;
    cJSON_Delete(json);
    if (text == NULL)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for %s", file);
    STP_TRY(stp_output_create(&output, file, force, err));
    STP_TRY(stp_output_write(output, text, strlen(text), err));
    STP_TRY(stp_output_write(output, "\n", 1, err));
    STP_TRY(stp_output_commit(&output, err));
done:
    stp_output_destroy(&output);
    free(text);
    return status;
}
