/* Places in a model that the user marked. */
#include "tools/view/kept/view_marked.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define ENDING ".marks.json"

static stp_status read_mark(view_mark *out, const cJSON *json, const char *path, size_t index,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(json, "name");
    double p[3] = {0.0};
    if (!stp_json_has(json, "position"))
        return stp_error_set(err, STP_FORMAT, "%s: mark %zu has no \"position\"", path, index + 1);
    STP_TRY(stp_json_numbers(json, "position", p, 3, path, err));
    snprintf(out->name, sizeof out->name, "%s", cJSON_IsString(name) ? name->valuestring : "");
    out->position = (stp_dvec3){p[0], p[1], p[2]};
done:
    return status;
}

static stp_status read_file(view_marked *m, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    cJSON *json = NULL;
    STP_TRY(stp_json_load(&json, path, "a list of marks: an object with an array \"marks\"", err));
    const cJSON *marks = cJSON_GetObjectItemCaseSensitive(json, "marks"), *mark = NULL;
    if (!cJSON_IsArray(marks)) {
        status = stp_error_set(err, STP_FORMAT, "%s: \"marks\" is no array", path);
        goto done;
    }
    if (cJSON_GetArraySize(marks) > VIEW_MARKED_LIMIT) {
        status = stp_error_set(err, STP_LIMIT, "%s: there are more than %d marks", path,
                               VIEW_MARKED_LIMIT);
        goto done;
    }
    cJSON_ArrayForEach(mark, marks)
    {
        STP_TRY(read_mark(&m->items[m->count], mark, path, m->count, err));
        m->count++;
    }
done:
    if (status != STP_OK)
        m->count = 0;
    cJSON_Delete(json);
    return status;
}

stp_status view_marked_load(view_marked *m, const char *file, const char *model, stp_error *err)
{
    stp_status status = STP_OK;
    char path[VIEW_PATH_BYTES];
    bool found = false;
    m->count = 0;
    m->path[0] = '\0';
    m->given = file != NULL;
    if (file != NULL) {
        if (snprintf(path, sizeof path, "%s", file) >= (int)sizeof path)
            return stp_error_set(err, STP_LIMIT, "the file of marks has too long a name");
        found = access(path, F_OK) == 0;
        memcpy(m->path, path, sizeof path);
    } else {
        STP_TRY(view_files_find(path, &found, model, ENDING, err));
    }
    if (!found)
        return STP_OK;
    STP_TRY(read_file(m, path, err));
    memcpy(m->path, path, sizeof path);
done:
    return status;
}

static cJSON *to_json(const void *context)
{
    const view_marked *m = context;
    cJSON *json = cJSON_CreateObject();
    cJSON *marks = cJSON_AddArrayToObject(json, "marks");
    for (size_t i = 0; i < m->count; i++) {
        cJSON *mark = cJSON_CreateObject();
        cJSON_AddStringToObject(mark, "name", m->items[i].name);
        stp_json_add_vector(mark, "position", m->items[i].position);
        cJSON_AddItemToArray(marks, mark);
    }
    return json;
}

stp_status view_marked_save(view_marked *m, const char *model, stp_error *err)
{
    return m->given ? stp_json_save(to_json(m), m->path, true, err)
                    : view_files_save(m->path, model, ENDING, to_json, m, err);
}

bool view_marked_add(view_marked *m, stp_dvec3 position)
{
    if (m->count == VIEW_MARKED_LIMIT)
        return false;
    view_mark *mark = &m->items[m->count++];
    mark->position = position;
    snprintf(mark->name, sizeof mark->name, "mark %zu", m->count);
    return true;
}

void view_marked_remove(view_marked *m, size_t index)
{
    if (index >= m->count)
        return;
    memmove(m->items + index, m->items + index + 1, (m->count - index - 1) * sizeof *m->items);
    m->count--;
}
