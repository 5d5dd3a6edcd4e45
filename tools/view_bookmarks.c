/* Views that were kept. */
#include "tools/view_bookmarks.h"

#include "base/file.h"
#include "runtime/json.h"
#include "tools/cli.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define ENDING ".views.json"

static stp_status read_view(view_bookmark *out, const cJSON *json, const char *path, size_t index,
                            stp_error *err)
{
    stp_status status = STP_OK;
    double eye[3] = {0.0}, look[3] = {0.0}, up[3] = {0.0, 1.0, 0.0};
    view_bookmark view = {.camera = {.fovy_deg = STP_CAMERA_FOVY_DEG}};
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(json, "name");
    const char *const keys[] = {"eye", "look", "up"};
    for (int i = 0; i < 3; i++)
        if (!cJSON_HasObjectItem(json, keys[i]))
            return stp_error_set(err, STP_FORMAT, "%s: view %zu has no \"%s\"", path, index + 1,
                                 keys[i]);
    STP_TRY(stp_json_numbers(json, "eye", eye, 3, path, err));
    STP_TRY(stp_json_numbers(json, "look", look, 3, path, err));
    STP_TRY(stp_json_numbers(json, "up", up, 3, path, err));
    STP_TRY(stp_json_numbers(json, "fovy_deg", &view.camera.fovy_deg, 1, path, err));
    STP_TRY(stp_json_numbers(json, "height", &view.camera.height, 1, path, err));
    view.camera.eye = (stp_dvec3){eye[0], eye[1], eye[2]};
    view.camera.look = (stp_dvec3){look[0], look[1], look[2]};
    view.camera.up = (stp_dvec3){up[0], up[1], up[2]};
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
    /* what could not be written beside the model is newer */
    bool found =
        view_files_model_state(path, model, ENDING, NULL) == STP_OK && access(path, F_OK) == 0;
    if (!found && !view_files_is_address(model)) {
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

static cJSON *numbers(stp_dvec3 v)
{
    const double values[3] = {v.x, v.y, v.z};
    return cJSON_CreateDoubleArray(values, 3);
}

static cJSON *to_json(const view_bookmarks *b)
{
    cJSON *json = cJSON_CreateObject();
    cJSON *views = cJSON_AddArrayToObject(json, "views");
    for (size_t i = 0; i < b->count; i++) {
        const stp_camera *c = &b->items[i].camera;
        cJSON *view = cJSON_CreateObject();
        cJSON_AddStringToObject(view, "name", b->items[i].name);
        cJSON_AddItemToObject(view, "eye", numbers(c->eye));
        cJSON_AddItemToObject(view, "look", numbers(c->look));
        cJSON_AddItemToObject(view, "up", numbers(c->up));
        cJSON_AddNumberToObject(view, "fovy_deg", c->fovy_deg);
        if (c->height > 0.0)
            cJSON_AddNumberToObject(view, "height", c->height);
        cJSON_AddItemToArray(views, view);
    }
    return json;
}

stp_status view_bookmarks_save(view_bookmarks *b, const char *model, stp_error *err)
{
    stp_status status = STP_OK;
    char path[VIEW_PATH_BYTES];
    if (b->path[0] != '\0' && cli_write_json(b->path, to_json(b), true, NULL) == STP_OK)
        return STP_OK;
    if (!view_files_is_address(model)) {
        STP_TRY(beside(path, model, err));
        if (cli_write_json(path, to_json(b), true, NULL) == STP_OK) {
            memcpy(b->path, path, sizeof path);
            return STP_OK;
        }
    }
    STP_TRY(view_files_model_state(path, model, ENDING, err));
    STP_TRY(view_files_make_folders(path, err));
    STP_TRY(cli_write_json(path, to_json(b), true, err));
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
