/* Reads and writes the repairs in a repaired file's metadata. */
#include "formats/chunk/repair/repair_note.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The first item of a list; NULL if there is no such list. */
static cJSON *first_of(const cJSON *json, const char *name)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(json, name);
    return cJSON_IsArray(list) ? list->child : NULL;
}

/* The chunk that a record names; STP_CHUNK_NONE if it names none. */
static uint32_t chunk_of(const cJSON *record, uint32_t chunk_count)
{
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(record, "chunk");
    double id = cJSON_IsNumber(number) ? number->valuedouble : -1.0;
    return id >= 0.0 && id < (double)chunk_count ? (uint32_t)id : STP_CHUNK_NONE;
}

void stp_repair_note_stand_ins(const char *metadata_json, bool *marks, uint32_t chunk_count)
{
    cJSON *json = cJSON_Parse(metadata_json);
    for (const cJSON *repair = first_of(json, "repaired"); repair; repair = repair->next)
        for (const cJSON *record = first_of(repair, "lost"); record; record = record->next) {
            uint32_t id = chunk_of(record, chunk_count);
            if (id != STP_CHUNK_NONE)
                marks[id] = true;
        }
    cJSON_Delete(json);
}

static double number_of(const cJSON *json, const char *name)
{
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(json, name);
    double value = cJSON_IsNumber(number) ? number->valuedouble : 0.0;
    return value > 0.0 && value < 1e15 ? value : 0.0;
}

stp_repair_sum stp_repair_note_sum(const char *metadata_json)
{
    stp_repair_sum sum = {0};
    cJSON *json = cJSON_Parse(metadata_json);
    for (const cJSON *repair = first_of(json, "repaired"); repair; repair = repair->next) {
        sum.repairs++;
        sum.points_lost += number_of(repair, "points_lost");
        sum.stand_ins = number_of(repair, "stand_ins"); /* last one: the whole file now */
    }
    cJSON_Delete(json);
    return sum;
}

/* ---- writing ---- */

static void add_id(cJSON *json, const char *name, uint32_t id)
{
    if (id == STP_CHUNK_NONE)
        cJSON_AddNullToObject(json, name);
    else
        cJSON_AddNumberToObject(json, name, id);
}

/* Earlier records name chunks by the damaged file's ids: replaces them by those of the output. */
static void renumber(const cJSON *json, const stp_repair_plan *plan)
{
    for (const cJSON *repair = first_of(json, "repaired"); repair; repair = repair->next)
        for (cJSON *record = first_of(repair, "lost"); record; record = record->next) {
            uint32_t id = chunk_of(record, plan->count);
            if (id == STP_CHUNK_NONE)
                continue;
            cJSON_DeleteItemFromObjectCaseSensitive(record, "chunk");
            add_id(record, "chunk", plan->nodes[id].id);
        }
}

static void say_lost(const stp_repair_plan *plan, uint32_t id, uint64_t points, const stp_dbox *box)
{
    const stp_repair_node *node = &plan->nodes[id];
    char what[64] = "points", where[200] = "", rest[100] = "nothing stands in for them";
    if (points > 0)
        snprintf(what, sizeof what, "%" PRIu64 " points", points);
    if (box)
        snprintf(where, sizeof where, " in the box %.17g %.17g %.17g to %.17g %.17g %.17g",
                 box->min.x, box->min.y, box->min.z, box->max.x, box->max.y, box->max.z);
    if (node->fate == STP_FATE_COARSE)
        snprintf(rest, sizeof rest, "%" PRIu64 " samples of level %d stand in for them",
                 node->stand_ins, plan->damaged->finest[id]);
    else if (node->fate == STP_FATE_PARENT)
        snprintf(rest, sizeof rest, "%" PRIu64 " samples of the chunk above stand in for them",
                 node->stand_ins);
    stp_damaged_say(plan->damaged, "chunk %" PRIu32 ": %s%s are lost: %s", id, what, where, rest);
}

static void add_lost(cJSON *list, const stp_repair_plan *plan, uint32_t id)
{
    const stp_repair_node *node = &plan->nodes[id];
    const stp_chunk_entry *e = &plan->damaged->entries[id];
    bool known = plan->damaged->known[id], leaf = known && e->child_count == 0;
    stp_dbox world = known ? stp_chunk_entry_box(e) : stp_dbox_empty();
    uint64_t points = leaf ? e->sample_count[0] : 0;
    cJSON *record = cJSON_CreateObject();
    cJSON_AddItemToArray(list, record);
    add_id(record, "chunk", node->id);
    cJSON_AddNumberToObject(record, "was", id);
    cJSON_AddNumberToObject(record, "stand_ins", (double)node->stand_ins);
    if (leaf)
        cJSON_AddNumberToObject(record, "points", (double)points);
    if (known) {
        const double box[6] = {world.min.x, world.min.y, world.min.z,
                               world.max.x, world.max.y, world.max.z};
        cJSON_AddItemToObject(record, "box", cJSON_CreateDoubleArray(box, 6));
    }
    say_lost(plan, id, points, known ? &world : NULL);
}

/* An inner chunk that is gone has lost no points itself. */
static bool is_lost(const stp_repair_plan *plan, uint32_t id)
{
    const stp_repair_node *node = &plan->nodes[id];
    bool inner = plan->damaged->known[id] && plan->damaged->entries[id].child_count > 0;
    return node->fate == STP_FATE_COARSE || node->fate == STP_FATE_PARENT ||
           (node->fate == STP_FATE_GONE && !inner);
}

static void add_rebuilt(cJSON *repair, const stp_repair_plan *plan)
{
    cJSON *rebuilt = cJSON_AddArrayToObject(repair, "rebuilt");
    cJSON *raised = cJSON_AddArrayToObject(repair, "raised");
    for (uint32_t id = 0; id < plan->count; id++) {
        const stp_repair_node *node = &plan->nodes[id];
        if (node->fate == STP_FATE_REBUILT) {
            cJSON_AddItemToArray(rebuilt, cJSON_CreateNumber(node->id));
            stp_damaged_say(plan->damaged, "chunk %" PRIu32 ": rebuilt from those under it", id);
        } else if (node->raised) {
            cJSON_AddItemToArray(raised, cJSON_CreateNumber(node->id));
        }
    }
    if (cJSON_GetArraySize(raised) > 0)
        stp_damaged_say(plan->damaged, "%d chunk%s: errors raised for changes beside or below",
                        cJSON_GetArraySize(raised), cJSON_GetArraySize(raised) == 1 ? "" : "s");
}

/* Adds the damaged metadata as found, as far as it is plain text. */
static void add_found(cJSON *repair, const stp_damaged *d)
{
    char *text = strdup(d->metadata);
    for (char *c = text; c && *c; c++)
        if (*c < 32 || *c > 126)
            *c = '?';
    if (text)
        cJSON_AddStringToObject(repair, "metadata_found", text);
    free(text);
}

static cJSON *parse_or_make(const stp_damaged *d)
{
    cJSON *json = d->metadata_lost ? NULL : cJSON_Parse(d->metadata);
    if (cJSON_IsObject(json))
        return json;
    cJSON_Delete(json);
    json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "lambda", d->header.lambda);
    cJSON_AddStringToObject(json, "orientation",
                            stp_orientation_name((stp_orientation)d->header.orientation));
    return json;
}

char *stp_repair_note_write(const stp_repair_plan *plan, const stp_repair_result *result)
{
    const stp_damaged *d = plan->damaged;
    cJSON *json = parse_or_make(d);
    cJSON *repairs = cJSON_GetObjectItemCaseSensitive(json, "repaired");
    cJSON *repair = cJSON_CreateObject();
    if (!cJSON_IsArray(repairs)) {
        cJSON_DeleteItemFromObjectCaseSensitive(json, "repaired");
        repairs = cJSON_AddArrayToObject(json, "repaired");
    }
    renumber(json, plan);
    cJSON_DeleteItemFromObjectCaseSensitive(json, "closed"); /* it may be open now */
    cJSON_AddNumberToObject(repair, "points_lost", (double)result->points_lost);
    cJSON_AddNumberToObject(repair, "stand_ins", (double)result->stand_ins);
    if (d->header_told)
        cJSON_AddTrueToObject(repair, "header_told");
    if (d->entries_told > 0)
        cJSON_AddNumberToObject(repair, "entries_told", d->entries_told);
    if (d->metadata_lost)
        add_found(repair, d);
    cJSON *lost = cJSON_AddArrayToObject(repair, "lost");
    for (uint32_t id = 0; id < plan->count; id++)
        if (is_lost(plan, id))
            add_lost(lost, plan, id);
    add_rebuilt(repair, plan);
    cJSON_AddItemToArray(repairs, repair);
    char *text = cJSON_PrintUnformatted(json);
    cJSON_Delete(json);
    return text;
}
