/* The list of models. */
#include "tools/view/view_scene.h"

#include "base/memory.h"
#include "formats/chunk/convert.h"
#include "tools/view/kept/view_files.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Gets the first quoted name of well-known text: PROJCS["ETRS89 / UTM zone 32N",... */
static void read_system(const char *wkt, char *out, size_t bytes)
{
    const char *begin = strchr(wkt, '"');
    if (begin != NULL)
        snprintf(out, bytes, "%.*s", (int)strcspn(begin + 1, "\""), begin + 1);
}

/* Gets the last unit of length before `end` of well-known text: UNIT["metre",1], or LENGTHUNIT.
 * None if the last unit is an angle. US survey feet are 2 in a million longer than others, so they
 * are told apart. */
static void read_unit(const char *wkt, const char *end, char *out, size_t bytes)
{
    static const char mark[] = "UNIT[\"";
    const char *last = NULL;
    for (const char *at = wkt; (at = strstr(at, mark)) != NULL && at < end; last = at)
        at += sizeof mark - 1;
    static const char *const angles[] = {"degree", "grad", "radian", "gon"};
    for (size_t i = 0; last != NULL && i < sizeof angles / sizeof *angles; i++)
        if (strncasecmp(last, angles[i], strlen(angles[i])) == 0)
            return;
    if (last == NULL)
        return;
    snprintf(out, bytes, "%.*s", (int)strcspn(last, "\""), last);
    if (strcasecmp(out, "metre") == 0 || strcasecmp(out, "meter") == 0)
        snprintf(out, bytes, "m");
    else if (strcasestr(out, "foot") || strcasestr(out, "feet"))
        snprintf(out, bytes, strcasestr(out, "us") ? "US ft" : "ft");
}

/* Gets the units of x and y, and of heights: the last one before the part of a vertical system, and
 * the last of all. */
static void read_units(const char *wkt, view_model *m)
{
    static const char *const parts[] = {"VERT_CS[", "VERTCS[", "VERTCRS["};
    const char *end = wkt + strlen(wkt), *level_end = NULL;
    for (size_t i = 0; i < sizeof parts / sizeof *parts && level_end == NULL; i++)
        level_end = strstr(wkt, parts[i]);
    if (strncmp(wkt, "GEOG", 4) != 0) /* its x and y are angles */
        read_unit(wkt, level_end != NULL ? level_end : end, m->units[VIEW_UNIT_LEVEL],
                  sizeof *m->units);
    read_unit(wkt, end, m->units[VIEW_UNIT_HEIGHT], sizeof *m->units);
}

/* Reads metadata: "a.las and 3 more", the coordinate system, and what intensities mean. */
static void read_metadata(view_model *m)
{
    const stp_chunk_file_info *info = m->model->info;
    cJSON *json = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *sources = cJSON_GetObjectItemCaseSensitive(json, "sources");
    const cJSON *first = cJSON_GetArrayItem(sources, 0);
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(first, "name");
    const cJSON *wkt = cJSON_GetObjectItemCaseSensitive(first, "wkt");
    int more = cJSON_GetArraySize(sources) - 1;
    if (cJSON_IsString(name) && more > 0)
        snprintf(m->sources, sizeof m->sources, "%.120s and %d more", name->valuestring, more);
    else if (cJSON_IsString(name))
        snprintf(m->sources, sizeof m->sources, "%.150s", name->valuestring);
    if (cJSON_IsString(wkt)) {
        read_system(wkt->valuestring, m->system, sizeof m->system);
        read_units(wkt->valuestring, m);
    }
    m->intensity_top = stp_chunk_file_intensity_top(info);
    cJSON_Delete(json);
}

static void close_model(view_model *m)
{
    stp_model_close(&m->model);
    free(m->path);
    *m = (view_model){0};
}

size_t view_scene_find(const view_scene *scene, const char *path)
{
    size_t i = 0;
    while (i < scene->count && strcmp(scene->models[i].path, path) != 0)
        i++;
    return i;
}

stp_status view_scene_put(view_scene *scene, const char *path, stp_model **model, stp_model **old,
                          stp_error *err)
{
    stp_status status = STP_OK;
    const size_t index = view_scene_find(scene, path);
    view_model *m = &scene->models[index];
    if (index == VIEW_MODELS_LIMIT)
        return stp_error_set(err, STP_LIMIT, "%s: there are %d models already: remove one", path,
                             VIEW_MODELS_LIMIT);
    if (index == scene->count)
        STP_TRY(stp_text_copy(&m->path, path, "a path", err));
    *old = m->model;
    m->model = *model;
    *model = NULL;
    m->name = stp_is_address(path) ? view_files_base(stp_chunk_file_path(m->model->file))
                                   : view_files_base(m->path);
    m->sources[0] = m->system[0] = m->units[0][0] = m->units[1][0] = '\0';
    read_metadata(m);
    scene->count += index == scene->count;
    view_scene_update(scene);
done:
    return status;
}

stp_status view_scene_add(view_scene *scene, const draw_options *options, const char *path,
                          stp_error *err)
{
    stp_status status = STP_OK;
    stp_model *model = NULL, *none = NULL;
    if (view_scene_find(scene, path) < scene->count)
        return stp_error_set(err, STP_EXISTS, "%s: is shown already", path);
    STP_TRY(draw_options_open_model(options, path, &model, err));
    STP_TRY(view_scene_put(scene, path, &model, &none, err));
done:
    stp_model_close(&model);
    return status;
}

const char *view_scene_unit(const view_scene *scene, view_unit of)
{
    const char *unit = "";
    if (of == VIEW_UNIT_ANY) {
        unit = view_scene_unit(scene, VIEW_UNIT_HEIGHT);
        return strcmp(unit, view_scene_unit(scene, VIEW_UNIT_LEVEL)) == 0 ? unit : "";
    }
    for (size_t i = 0; i < scene->count; i++) {
        const char *own = scene->models[i].units[of];
        if (i > 0 && strcmp(own, unit) != 0)
            return "";
        unit = own;
    }
    return unit;
}

void view_scene_remove(view_scene *scene, size_t index)
{
    close_model(&scene->models[index]);
    memmove(scene->models + index, scene->models + index + 1,
            (scene->count - index - 1) * sizeof *scene->models);
    scene->models[--scene->count] = (view_model){0};
    view_scene_update(scene);
}

uint32_t view_scene_hidden(const view_scene *scene)
{
    uint32_t hidden = 0;
    for (size_t i = 0; i < scene->count; i++)
        hidden |= scene->models[i].hidden ? 1u << i : 0u;
    return hidden;
}

void view_scene_update(view_scene *scene)
{
    bool any = false, intensities = false;
    for (size_t i = 0; i < scene->count; i++)
        any = any || !scene->models[i].hidden;
    scene->box = stp_dbox_empty();
    scene->point_count = 0;
    scene->attributes = 0;
    scene->intensity_top = 0.0;
    for (size_t i = 0; i < scene->count; i++) {
        const stp_chunk_file_info *info = scene->models[i].model->info;
        if (any && scene->models[i].hidden)
            continue;
        stp_dbox_join(&scene->box, &info->box);
        scene->point_count += info->point_count;
        scene->attributes |= info->attributes;
        if ((info->attributes & STP_HAS_INTENSITY) == 0)
            continue;
        const double top = scene->models[i].intensity_top;
        scene->intensity_top = !intensities || top == scene->intensity_top ? top : 0.0;
        intensities = true;
    }
    scene->ball = scene->count == 1 ? scene->models[0].model->ball : stp_ball_from_box(&scene->box);
}

void view_scene_clear(view_scene *scene)
{
    while (scene->count > 0)
        close_model(&scene->models[--scene->count]);
}
