/* The list of a model's attributes as JSON. */
#include "formats/chunk/attribute/attribute_json.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const coarse_names[] = {
    [STP_COARSE_NOT] = "",
    [STP_COARSE_RED] = "red",
    [STP_COARSE_GREEN] = "green",
    [STP_COARSE_BLUE] = "blue",
    [STP_COARSE_INTENSITY] = "intensity",
};

static cJSON *to_json(const stp_attribute *a)
{
    cJSON *json = cJSON_CreateObject();
    char missing[24];
    cJSON_AddStringToObject(json, "name", a->name);
    cJSON_AddStringToObject(json, "type", stp_attribute_type_name(a->type));
    if (a->scale != 1.0)
        cJSON_AddNumberToObject(json, "scale", a->scale);
    if (a->offset != 0.0)
        cJSON_AddNumberToObject(json, "offset", a->offset);
    if (a->has_missing && stp_attribute_is_float(a->type)) {
        cJSON_AddStringToObject(json, "missing", "nan");
    } else if (a->has_missing) { /* as a text: it may have more digits than a double */
        snprintf(missing, sizeof missing, "%" PRId64, a->missing);
        cJSON_AddStringToObject(json, "missing", missing);
    }
    if (a->coarse != STP_COARSE_NOT)
        cJSON_AddStringToObject(json, "coarse", coarse_names[a->coarse]);
    if (a->coarse != STP_COARSE_NOT)
        cJSON_AddNumberToObject(json, "coarse_scale", a->coarse_scale);
    if (a->derived)
        cJSON_AddBoolToObject(json, "derived", true);
    return json;
}

stp_status stp_attribute_list_write(const stp_attribute_list *list, char **text, stp_error *err)
{
    cJSON *json = cJSON_CreateArray();
    for (uint32_t i = 0; i < list->count; i++)
        cJSON_AddItemToArray(json, to_json(&list->items[i]));
    *text = cJSON_PrintUnformatted(json);
    cJSON_Delete(json);
    return *text ? STP_OK : stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for attributes");
}

static const char *text_of(const cJSON *json, const char *key)
{
    return cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, key));
}

/* `otherwise` if there is none; NaN if it is no number. */
static double number_of(const cJSON *json, const char *key, double otherwise)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, key);
    return item == NULL ? otherwise : cJSON_IsNumber(item) ? item->valuedouble : (double)NAN;
}

static bool read_missing(stp_attribute *out, const cJSON *json)
{
    const char *text = text_of(json, "missing");
    char *end = NULL;
    if (!text)
        return !cJSON_HasObjectItem(json, "missing");
    out->has_missing = true;
    if (stp_attribute_is_float(out->type))
        return strcmp(text, "nan") == 0;
    out->missing = strtoll(text, &end, 10);
    return end != text && *end == '\0';
}

static bool read_coarse(stp_attribute *out, const cJSON *json)
{
    const char *text = text_of(json, "coarse");
    if (!text)
        return !cJSON_HasObjectItem(json, "coarse");
    for (int i = STP_COARSE_RED; i <= STP_COARSE_INTENSITY; i++)
        if (strcmp(text, coarse_names[i]) == 0)
            out->coarse = (stp_attribute_coarse)i;
    out->coarse_scale = number_of(json, "coarse_scale", 1.0);
    out->derived = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(json, "derived"));
    return out->coarse != STP_COARSE_NOT && !stp_attribute_is_float(out->type) &&
           out->coarse_scale >= 0.0 && out->coarse_scale <= 65536.0;
}

static bool read_name(stp_attribute *out, const cJSON *json)
{
    const char *name = text_of(json, "name");
    const size_t length = name ? strlen(name) : 0;
    if (length == 0 || length >= sizeof out->name)
        return false;
    for (size_t i = 0; i < length; i++)
        if ((unsigned char)name[i] < 32 || (unsigned char)name[i] > 126)
            return false;
    memcpy(out->name, name, length + 1);
    return true;
}

/* What is wrong, or NULL. */
static const char *read_one(stp_attribute *out, const cJSON *json)
{
    const char *type = text_of(json, "type");
    *out = (stp_attribute){.type = type ? stp_attribute_type_from(type) : STP_ATTRIBUTE_TYPE_COUNT,
                           .scale = number_of(json, "scale", 1.0),
                           .offset = number_of(json, "offset", 0.0)};
    if (!read_name(out, json))
        return "has no name of printable ASCII";
    if (out->type == STP_ATTRIBUTE_TYPE_COUNT)
        return "has an unknown type";
    if (!isfinite(out->scale) || out->scale == 0.0 || !isfinite(out->offset))
        return "has no finite scale and offset";
    return read_missing(out, json) && read_coarse(out, json) ? NULL
                                                             : "has a wrong missing or coarse";
}

stp_status stp_attribute_list_read(stp_attribute_list *out, const char *text, size_t bytes,
                                   stp_error *err)
{
    stp_status status = STP_OK;
    cJSON *json = cJSON_ParseWithLength(text, bytes);
    const cJSON *item = NULL;
    out->count = 0;
    if (!cJSON_IsArray(json) || cJSON_GetArraySize(json) > (int)STP_ATTRIBUTES_LIMIT) {
        status = stp_error_set(err, STP_CORRUPT, "the list of attributes is no array of at most %u",
                               STP_ATTRIBUTES_LIMIT);
        goto done;
    }
    cJSON_ArrayForEach(item, json)
    {
        stp_attribute one;
        const char *fault = read_one(&one, item);
        if (!fault && stp_attribute_find(out, one.name) != UINT32_MAX)
            fault = "has the name of another";
        if (fault) {
            status = stp_error_set(err, STP_CORRUPT, "attribute %u %s", out->count, fault);
            goto done;
        }
        out->items[out->count++] = one;
    }
done:
    cJSON_Delete(json);
    if (status != STP_OK)
        out->count = 0;
    return status;
}
