/* Views that the user kept. */
#include "tools/view/kept/view_bookmarks.h"

#include "runtime/camera/camera_json.h"

#include <stdio.h>
#include <string.h>

#define ENDING ".views.json"

static stp_status read_view(view_bookmark *out, const cJSON *json, const char *path, size_t index,
                            stp_error *err)
{
    stp_status status = STP_OK;
    view_bookmark view = {.camera = {.fovy_deg = STP_CAMERA_FOVY_DEG}};
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(json, "name");
    const char *const keys[] = {"eye", "look", "up"};
    for (int i = 0; i < 3; i++)
        if (!stp_json_has(json, keys[i]))
            return stp_error_set(err, STP_FORMAT, "%s: view %zu has no \"%s\"", path, index + 1,
                                 keys[i]);
    STP_TRY(stp_camera_read(&view.camera, json, path, err));
    snprintf(view.name, sizeof view.name, "%s", cJSON_IsString(name) ? name->valuestring : "");
    const stp_ball any = {view.camera.look, 1.0};
    stp_view made;
    STP_TRY(stp_view_create(&made, &view.camera, &any, 1, 1, err));
    *out = view;
done:
    return status;
}

static stp_status read_file(view_bookmarks *b, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    cJSON *json = NULL;
    STP_TRY(stp_json_load(&json, path, "a list of views: an object with an array \"views\"", err));
    const cJSON *views = cJSON_GetObjectItemCaseSensitive(json, "views"), *view = NULL;
    if (!cJSON_IsArray(views)) {
        status = stp_error_set(err, STP_FORMAT, "%s: \"views\" is no array", path);
        goto done;
    }
    if (cJSON_GetArraySize(views) > VIEW_BOOKMARKS_LIMIT) {
        status = stp_error_set(err, STP_LIMIT, "%s: there are more than %d views", path,
                               VIEW_BOOKMARKS_LIMIT);
        goto done;
    }
    b->count = 0;
    cJSON_ArrayForEach(view, views)
    {
        STP_TRY(read_view(&b->items[b->count], view, path, b->count, err));
        b->count++;
    }
done:
    if (status != STP_OK)
        b->count = 0;
    cJSON_Delete(json);
    return status;
}

stp_status view_bookmarks_load(view_bookmarks *b, const char *model, stp_error *err)
{
    stp_status status = STP_OK;
    char path[VIEW_PATH_BYTES];
    bool found = false;
    b->count = 0;
    b->path[0] = '\0';
    STP_TRY(view_files_find(path, &found, model, ENDING, err));
    if (!found)
        return STP_OK;
    STP_TRY(read_file(b, path, err));
    memcpy(b->path, path, sizeof path);
done:
    return status;
}

static cJSON *to_json(const void *context)
{
    const view_bookmarks *b = context;
    cJSON *json = cJSON_CreateObject();
    cJSON *views = cJSON_AddArrayToObject(json, "views");
    for (size_t i = 0; i < b->count; i++) {
        cJSON *view = cJSON_CreateObject();
        cJSON_AddStringToObject(view, "name", b->items[i].name);
        stp_camera_write(&b->items[i].camera, view);
        cJSON_AddItemToArray(views, view);
    }
    return json;
}

stp_status view_bookmarks_save(view_bookmarks *b, const char *model, stp_error *err)
{
    return view_files_save(b->path, model, ENDING, to_json, b, err);
}

bool view_bookmarks_add(view_bookmarks *b, const stp_camera *camera)
{
    if (b->count == VIEW_BOOKMARKS_LIMIT)
        return false;
    view_bookmark *view = &b->items[b->count++];
    *view = (view_bookmark){.camera = *camera};
    snprintf(view->name, sizeof view->name, "view %zu", b->count);
    return true;
}

void view_bookmarks_remove(view_bookmarks *b, size_t index)
{
    if (index >= b->count)
        return;
    memmove(b->items + index, b->items + index + 1, (b->count - index - 1) * sizeof *b->items);
    b->count--;
}
