/* Remembered settings. */
#include "tools/view/view_settings.h"

#include "base/json.h"

#include <string.h>

static const struct {
    const char *name;
    bool open;
} sections[VIEW_SECTION_COUNT] = {
#define X(name, draw, title, open) {#name, open},
    VIEW_SECTION_LIST(X)
#undef X
};

static void read_bool(const cJSON *json, const char *key, bool *out)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, key);
    if (cJSON_IsBool(item))
        *out = cJSON_IsTrue(item);
}

typedef struct settings {
    bool panels, open[VIEW_SECTION_COUNT];
    int shot_size;
} settings;

/* Reads the settings of the file; the others keep their defaults. */
static settings read_settings(void)
{
    char path[VIEW_PATH_BYTES];
    cJSON *json = NULL;
    double size = 0.0;
    settings s = {.panels = true};
    for (int i = 0; i < VIEW_SECTION_COUNT; i++)
        s.open[i] = sections[i].open;
    if (view_files_state(path, "view.json", NULL) != STP_OK ||
        stp_json_load(&json, path, "settings", NULL) != STP_OK)
        return s;
    const cJSON *opened = cJSON_GetObjectItemCaseSensitive(json, "open");
    read_bool(json, "panels", &s.panels);
    for (int i = 0; i < VIEW_SECTION_COUNT; i++)
        read_bool(opened, sections[i].name, &s.open[i]);
    if (stp_json_numbers(json, "screenshot", &size, 1, path, NULL) == STP_OK && size >= 0.0 &&
        size < VIEW_SHOT_SIZE_COUNT)
        s.shot_size = (int)size;
    cJSON_Delete(json);
    return s;
}

void view_settings_load(viewer *v)
{
    settings s = read_settings();
    v->panels_wanted = s.panels;
    v->shot_size = s.shot_size;
    memcpy(v->open, s.open, sizeof s.open);
}

void view_settings_save(const viewer *v)
{
    char path[VIEW_PATH_BYTES];
    settings s = read_settings();
    if (s.panels == v->panels_wanted && s.shot_size == v->shot_size &&
        memcmp(s.open, v->open, sizeof s.open) == 0)
        return;
    if (view_files_state(path, "view.json", NULL) != STP_OK ||
        view_files_make_folders(path, NULL) != STP_OK)
        return;
    cJSON *json = cJSON_CreateObject();
    cJSON_AddBoolToObject(json, "panels", v->panels_wanted);
    cJSON_AddNumberToObject(json, "screenshot", v->shot_size);
    cJSON *opened = cJSON_AddObjectToObject(json, "open");
    for (int i = 0; i < VIEW_SECTION_COUNT; i++)
        cJSON_AddBoolToObject(opened, sections[i].name, v->open[i]);
    stp_json_save(json, path, true, NULL);
}
