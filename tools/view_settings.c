/* Remembered settings. */
#include "tools/view_settings.h"

#include "runtime/json.h"

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

/* What the file says, over the defaults. */
static void read_settings(bool *panels, bool open[VIEW_SECTION_COUNT])
{
    char path[VIEW_PATH_BYTES];
    cJSON *json = NULL;
    *panels = true;
    for (int i = 0; i < VIEW_SECTION_COUNT; i++)
        open[i] = sections[i].open;
    if (view_files_state(path, "view.json", NULL) != STP_OK ||
        stp_json_load(&json, path, "settings", NULL) != STP_OK)
        return;
    const cJSON *opened = cJSON_GetObjectItemCaseSensitive(json, "open");
    read_bool(json, "panels", panels);
    for (int i = 0; i < VIEW_SECTION_COUNT; i++)
        read_bool(opened, sections[i].name, &open[i]);
    cJSON_Delete(json);
}

void view_settings_load(viewer *v)
{
    read_settings(&v->panels_wanted, v->open);
}

void view_settings_save(const viewer *v)
{
    char path[VIEW_PATH_BYTES];
    bool panels = false, open[VIEW_SECTION_COUNT];
    read_settings(&panels, open);
    if (panels == v->panels_wanted && memcmp(open, v->open, sizeof open) == 0)
        return;
    if (view_files_state(path, "view.json", NULL) != STP_OK)
        return;
    cJSON *json = cJSON_CreateObject();
    cJSON_AddBoolToObject(json, "panels", v->panels_wanted);
    cJSON *opened = cJSON_AddObjectToObject(json, "open");
    for (int i = 0; i < VIEW_SECTION_COUNT; i++)
        cJSON_AddBoolToObject(opened, sections[i].name, v->open[i]);
    cli_write_json(path, json, true, NULL);
}
