/* Remembers the files that were opened. */
#include "tools/view/dialog/view_recent.h"

#include "formats/chunk/byte_source.h"
#include "tools/view/kept/view_files.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

void view_recent_load(view_recent *out)
{
    char file[VIEW_PATH_BYTES];
    cJSON *json = NULL;
    const cJSON *path = NULL;
    *out = (view_recent){0};
    if (view_files_state(file, "recent.json", NULL) != STP_OK ||
        stp_json_load(&json, file, "recent files", NULL) != STP_OK)
        return;
    cJSON_ArrayForEach(path, cJSON_GetObjectItemCaseSensitive(json, "files"))
    {
        if (!cJSON_IsString(path) || strlen(path->valuestring) >= VIEW_PATH_BYTES ||
            out->count == VIEW_RECENT_LIMIT)
            continue;
        out->paths[out->count] = strdup(path->valuestring);
        out->count += out->paths[out->count] != NULL;
    }
    cJSON_Delete(json);
}

static void save(const view_recent *recent)
{
    char file[VIEW_PATH_BYTES];
    if (view_files_state(file, "recent.json", NULL) != STP_OK ||
        view_files_make_folders(file, NULL) != STP_OK)
        return;
    cJSON *json = cJSON_CreateObject();
    cJSON *files = cJSON_CreateStringArray((const char *const *)recent->paths, (int)recent->count);
    if (files != NULL && cJSON_AddItemToObject(json, "files", files))
        stp_json_save(json, file, true, NULL);
    else {
        cJSON_Delete(files);
        cJSON_Delete(json);
    }
}

static bool may_hold_secrets(const char *path)
{
    return stp_is_address(path) && strpbrk(path, "?@#") != NULL;
}

void view_recent_note(const char *path)
{
    char *whole = may_hold_secrets(path) ? NULL
                  : stp_is_address(path) ? strdup(path)
                                         : realpath(path, NULL);
    view_recent before, now = {.paths = {whole}, .count = 1};
    if (whole == NULL || strlen(whole) >= VIEW_PATH_BYTES) {
        free(whole);
        return;
    }
    view_recent_load(&before);
    for (size_t i = 0; i < before.count && now.count < VIEW_RECENT_LIMIT; i++)
        if (strcmp(before.paths[i], whole) != 0)
            now.paths[now.count++] = before.paths[i];
    save(&now);
    free(whole);
    view_recent_clear(&before);
}

void view_recent_clear(view_recent *recent)
{
    for (size_t i = 0; i < recent->count; i++)
        free(recent->paths[i]);
    *recent = (view_recent){0};
}
