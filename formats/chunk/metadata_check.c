/* Checks the metadata of a chunk file. */
#include "formats/chunk/metadata_check.h"

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <string.h>

/* A number of 0 to `most`. */
static bool is_count(const cJSON *number, double most)
{
    return cJSON_IsNumber(number) && number->valuedouble >= 0.0 && number->valuedouble <= most;
}

/* The last repair's stand_ins are at most the file's points. Points lost, and stand-ins of earlier
 * repairs, may be more than the file has left: they are only limited to 2^53, up to which counts in
 * JSON are exact. */
static bool is_repair(const cJSON *repair, uint64_t point_count)
{
    const double most = repair->next ? 0x1p53 : (double)point_count;
    return is_count(cJSON_GetObjectItemCaseSensitive(repair, "points_lost"), 0x1p53) &&
           is_count(cJSON_GetObjectItemCaseSensitive(repair, "stand_ins"), most) &&
           cJSON_IsArray(cJSON_GetObjectItemCaseSensitive(repair, "lost"));
}

static const char *repaired_fault(const cJSON *repaired, uint64_t point_count)
{
    if (repaired && !cJSON_IsArray(repaired))
        return "\"repaired\" is no list";
    for (const cJSON *repair = repaired ? repaired->child : NULL; repair; repair = repair->next)
        if (!is_repair(repair, point_count))
            return "one of \"repaired\" does not say how many points were lost and how many "
                   "samples, no more than the file's points, stand in for them";
    return NULL;
}

stp_status stp_metadata_check(const char *text, size_t bytes, uint64_t point_count, stp_error *err)
{
    const char *end = NULL;
    if (memchr(text, 0, bytes))
        return stp_error_set(err, STP_CORRUPT, "it has a zero byte in it");
    cJSON *json = cJSON_ParseWithLengthOpts(text, bytes + 1, &end, 1);
    const cJSON *repaired = cJSON_GetObjectItemCaseSensitive(json, "repaired");
    const char *fault =
        cJSON_IsObject(json) ? repaired_fault(repaired, point_count) : "it is not a JSON object";
    cJSON_Delete(json);
    return fault ? stp_error_set(err, STP_CORRUPT, "%s", fault) : STP_OK;
}
