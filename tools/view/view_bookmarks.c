/* Views that the user kept. */
#include "tools/view/view_bookmarks.h"

#include "formats/chunk/byte_source.h"
#include "runtime/camera/camera_json.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

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

static stp_status beside(char out[VIEW_PATH_BYTES], const char *model, stp_error *err)
{
    if (snprintf(out, VIEW_PATH_BYTES, "%s%s", model, ENDING) >= VIEW_PATH_BYTES)
        return stp_error_set(err, STP_LIMIT, "the model has too long a name");
    return STP_OK;
}

stp_status view_bookmarks_load(view_bookmarks *b, const char *model, stp_error *err)
{
    stp_status status = STP_OK;
    char path[VIEW_PATH_BYTES];
    b->count = 0;
    b->path[0] = '\0';
    /* the file in the state folder is newer: it could not be written beside the model */
    bool found =
        view_files_model_state(path, model, ENDING, NULL) == STP_OK && access(path, F_OK) == 0;
    if (!found && !stp_is_address(model)) {
        STP_TRY(beside(path, model, err));
        found = access(path, F_OK) == 0;
    }
    if (!found)
        return STP_OK;
    STP_TRY(read_file(b, path, err));
    memcpy(b->path, path, sizeof path);
done:
    return status;
}

static cJSON *to_json(const view_bookmarks *b)
{
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
    stp_status status = STP_OK;
    char path[VIEW_PATH_BYTES];
    if (b->path[0] != '\0' && stp_json_save(to_json(b), b->path, true, NULL) == STP_OK)
        return STP_OK;
    if (!stp_is_address(model)) {
        STP_TRY(beside(path, model, err));
        if (stp_json_save(to_json(b), path, true, NULL) == STP_OK) {
            memcpy(b->path, path, sizeof path);
            return STP_OK;
        }
    }
    STP_TRY(view_files_model_state(path, model, ENDING, err));
    STP_TRY(view_files_make_folders(path, err));
    STP_TRY(stp_json_save(to_json(b), path, true, err));
    memcpy(b->path, path, sizeof path);
done:
    return status;
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
