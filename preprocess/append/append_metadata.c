/* The metadata of a model that grows. */
#include "preprocess/append/append_job.h"
#include "preprocess/prep_metadata.h"

#include "base/json.h"

#include <cjson/cJSON.h>
#include <string.h>

/* Keys of the new points' metadata whose arrays follow those of the model. */
static const char *const joined_arrays[] = {"sources", "stations"};

const char *stp_append_refusal(const stp_chunk_file_info *info)
{
    cJSON *json = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const char *why = NULL;
    if (!cJSON_IsObject(json))
        why = "its metadata cannot be read";
    else if (cJSON_GetObjectItemCaseSensitive(json, "repaired"))
        why = "it was repaired, and its metadata names chunks by their numbers";
    else if (cJSON_GetObjectItemCaseSensitive(json, "resampled"))
        why = "it was resampled: prepare all inputs at once";
    cJSON_Delete(json);
    return why;
}

static double number_of(const cJSON *json, const char *key)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, key);
    return cJSON_IsNumber(item) ? item->valuedouble : 0.0;
}

double stp_append_noted(const stp_append *a, const char *key)
{
    cJSON *json = cJSON_ParseWithLength(a->info->metadata_json, a->info->metadata_bytes);
    const double value = number_of(json, key);
    cJSON_Delete(json);
    return value;
}

static void set_number(cJSON *json, const char *key, double value)
{
    cJSON_DeleteItemFromObjectCaseSensitive(json, key);
    stp_json_add_number(json, key, value);
}

static void join_array(cJSON *model, cJSON *more, const char *key)
{
    cJSON *from = cJSON_GetObjectItemCaseSensitive(more, key);
    cJSON *to = cJSON_GetObjectItemCaseSensitive(model, key);
    if (!cJSON_IsArray(from))
        return;
    if (!cJSON_IsArray(to))
        to = cJSON_AddArrayToObject(model, key);
    while (to && cJSON_GetArraySize(from) > 0)
        cJSON_AddItemToArray(to, cJSON_DetachItemFromArray(from, 0));
}

/* Adds counts to counts of the same names. */
static void add_counts(cJSON *model, const cJSON *more, const char *key)
{
    const cJSON *from = cJSON_GetObjectItemCaseSensitive(more, key), *item = NULL;
    cJSON *to = cJSON_GetObjectItemCaseSensitive(model, key);
    if (!cJSON_IsObject(from))
        return;
    if (!cJSON_IsObject(to))
        to = cJSON_AddObjectToObject(model, key);
    for (item = from->child; to && item; item = item->next)
        set_number(to, item->string, number_of(to, item->string) + item->valuedouble);
}

/* The displacement of all points. What was measured now counts old points, too, as not moved. */
static void join_displacement(cJSON *model, const cJSON *more, const stp_append *a,
                              const stp_displacement *now)
{
    const cJSON *from = cJSON_GetObjectItemCaseSensitive(more, "displacement");
    cJSON *to = cJSON_GetObjectItemCaseSensitive(model, "displacement");
    const double before = (double)a->info->point_count, after = (double)a->result->points_after;
    if (!cJSON_IsObject(from))
        return;
    if (!cJSON_IsObject(to))
        to = cJSON_AddObjectToObject(model, "displacement");
    set_number(to, "greatest", fmax(number_of(to, "greatest"), number_of(from, "greatest")));
    set_number(to, "mean", (number_of(to, "mean") * before + now->sum) / after);
    set_number(to, "beyond", number_of(to, "beyond") + number_of(from, "beyond"));
    if (cJSON_GetObjectItemCaseSensitive(to, "changed"))
        set_number(to, "changed", number_of(to, "changed") + number_of(from, "changed"));
}

/* What was true of all points, and may not be true of the new ones. */
static void settle(cJSON *model, const cJSON *more, const stp_append *a)
{
    const double precision = fmax(number_of(model, "precision"), number_of(more, "precision"));
    cJSON *moved = cJSON_GetObjectItemCaseSensitive(model, "displacement");
    set_number(model, "grown", number_of(model, "grown") + 1.0);
    set_number(model, "precision", precision);
    if (!cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(more, "exact"))) {
        cJSON_DeleteItemFromObjectCaseSensitive(model, "exact");
        cJSON_DeleteItemFromObjectCaseSensitive(moved, "changed");
    }
    if (!cJSON_GetObjectItemCaseSensitive(model, "intensity_max") &&
        cJSON_GetObjectItemCaseSensitive(more, "intensity_max")) {
        set_number(model, "intensity_max", number_of(more, "intensity_max"));
        if (number_of(more, "intensity_full") > 0.0)
            set_number(model, "intensity_full", number_of(more, "intensity_full"));
    }
    a->result->closed_lost = cJSON_GetObjectItemCaseSensitive(model, "closed") != NULL;
    cJSON_DeleteItemFromObjectCaseSensitive(model, "closed");
    cJSON_DeleteItemFromObjectCaseSensitive(model, "grid");
    cJSON_DeleteItemFromObjectCaseSensitive(model, "holes");
    cJSON_DeleteItemFromObjectCaseSensitive(model, "orientation");
    cJSON_AddStringToObject(model, "orientation", stp_orientation_name(a->job.stats->orientation));
}

char *stp_append_metadata(const stp_append *a, const stp_tree_stats *tree)
{
    const stp_outside none = {0};
    stp_prep_facts facts = {.source = a->job.source,
                            .stats = a->job.stats,
                            .stations = stp_prep_stations(&a->job),
                            .outside = &none,
                            .k = a->job.k,
                            .lambda = a->job.tree.lambda};
    char *text = stp_prep_metadata(&facts, tree);
    cJSON *more = cJSON_Parse(text);
    cJSON *model = cJSON_ParseWithLength(a->info->metadata_json, a->info->metadata_bytes);
    cJSON_free(text);
    text = NULL;
    if (cJSON_IsObject(more) && cJSON_IsObject(model)) {
        for (size_t i = 0; i < sizeof joined_arrays / sizeof *joined_arrays; i++)
            join_array(model, more, joined_arrays[i]);
        add_counts(model, more, "rejected");
        join_displacement(model, more, a, &tree->displacement);
        settle(model, more, a);
        text = cJSON_PrintUnformatted(model);
    }
    cJSON_Delete(more);
    cJSON_Delete(model);
    return text;
}
