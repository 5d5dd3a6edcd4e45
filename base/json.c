/* JSON files in and out; numbers. */
#include "base/json.h"

#include "base/file.h"
#include "base/memory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

stp_status stp_json_parse(cJSON **out, const char *text, size_t size, const char *name,
                          const char *expected, stp_error *err)
{
    cJSON *json = cJSON_ParseWithLength(text, size);
    if (cJSON_IsObject(json)) {
        *out = json;
        return STP_OK;
    }
    cJSON_Delete(json);
    return stp_error_set(err, STP_FORMAT, "%s: not %s", name, expected);
}

stp_status stp_json_load(cJSON **out, const char *path, const char *expected, stp_error *err)
{
    stp_status status = STP_OK;
    int descriptor = -1;
    uint64_t size = 0;
    char *text = NULL;
    STP_TRY(stp_file_open(path, &descriptor, &size, err));
    if (size > STP_JSON_BYTES_LIMIT) {
        status = stp_error_set(err, STP_FORMAT, "%s: over %u MiB are too large for %s", path,
                               STP_JSON_BYTES_LIMIT >> 20, expected);
        goto done;
    }
    STP_TRY(stp_alloc(&text, (size_t)size + 1, 1, "a JSON file", err));
    STP_TRY(stp_file_read_at(descriptor, path, 0, text, (size_t)size, err));
    STP_TRY(stp_json_parse(out, text, (size_t)size, path, expected, err));
done:
    free(text);
    if (descriptor >= 0)
        close(descriptor);
    return status;
}

stp_status stp_json_save(cJSON *json, const char *path, bool force, stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *output = NULL;
    char *text = json != NULL ? cJSON_Print(json) : NULL;
    cJSON_Delete(json);
    if (text == NULL)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for %s", path);
    STP_TRY(stp_output_create(&output, path, force, err));
    STP_TRY(stp_output_write(output, text, strlen(text), err));
    STP_TRY(stp_output_write(output, "\n", 1, err));
    STP_TRY(stp_output_commit(&output, err));
done:
    stp_output_destroy(&output);
    free(text);
    return status;
}

bool stp_json_has(const cJSON *object, const char *key)
{
    return cJSON_GetObjectItemCaseSensitive(object, key) != NULL;
}

stp_status stp_json_numbers(const cJSON *object, const char *key, double *out, int count,
                            const char *where, stp_error *err)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    if (item == NULL)
        return STP_OK;
    bool good = count == 1 ? cJSON_IsNumber(item)
                           : cJSON_IsArray(item) && cJSON_GetArraySize(item) == count;
    double values[6] = {0.0};
    for (int i = 0; good && i < count; i++) {
        const cJSON *number = count == 1 ? item : cJSON_GetArrayItem(item, i);
        good = cJSON_IsNumber(number) && isfinite(number->valuedouble);
        values[i] = good ? number->valuedouble : 0.0;
    }
    if (!good)
        return stp_error_set(err, STP_FORMAT, "%s: \"%s\" is not %d number%s", where, key, count,
                             count == 1 ? "" : "s");
    for (int i = 0; i < count; i++)
        out[i] = values[i];
    return STP_OK;
}

void stp_json_add_number(cJSON *object, const char *key, double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.17g", value);
    cJSON_AddRawToObject(object, key, text);
}

void stp_json_add_vector(cJSON *object, const char *key, stp_dvec3 v)
{
    char text[96];
    snprintf(text, sizeof text, "[%.17g, %.17g, %.17g]", v.x, v.y, v.z);
    cJSON_AddRawToObject(object, key, text);
}
