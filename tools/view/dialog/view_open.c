/* Draws the dialog for opening files. */
#include "tools/view/dialog/view_open.h"

#include "formats/chunk/byte_source.h"
#include "runtime/window/imgui_shim.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define WIDTH_PX 560.0
#define MARGIN_PX 24.0

static bool is_folder(const char *path)
{
    struct stat is;
    return stat(path, &is) == 0 && S_ISDIR(is.st_mode);
}

/* Goes to a folder; if it is gone, says so and stays. *path may be part of *o. */
static void enter(view_open *o, const char *path)
{
    stp_error err = {0};
    char *whole = realpath(path, NULL);
    o->why[0] = '\0';
    if (whole == NULL) {
        snprintf(o->why, sizeof o->why, "%.4000s: %s", path, strerror(errno));
        return;
    }
    snprintf(o->path, sizeof o->path, "%s", whole);
    free(whole);
    if (view_folder_list(&o->folder, o->path, &err) != STP_OK)
        snprintf(o->why, sizeof o->why, "%s", err.message);
    else if (o->folder.is_cut)
        snprintf(o->why, sizeof o->why, "Only %d names are shown.", VIEW_FOLDER_LIMIT);
    else if (o->folder.count == 0)
        snprintf(o->why, sizeof o->why, "No scan, no model and no folder is here.");
    o->field[0] = '\0';
}

void view_open_begin(view_open *o, const char *model)
{
    char folder[VIEW_PATH_BYTES] = ".";
    const char *slash = strrchr(model, '/');
    if (slash != NULL && !stp_is_address(model))
        snprintf(folder, sizeof folder, "%.*s", (int)(slash - model) + 1, model);
    view_open_clear(o);
    enter(o, "/"); /* if the model's folder is gone */
    enter(o, folder);
    view_recent_load(&o->recent);
    o->shown = true;
}

/* A press on a name. True if it was pressed twice. */
static bool press(view_open *o, const char *folder, const char *name)
{
    char whole[VIEW_PATH_BYTES];
    const int length = snprintf(whole, sizeof whole, "%s%s%s", folder,
                                folder[0] == '\0' || folder[1] == '\0' ? "" : "/", name);
    if (length >= (int)sizeof whole)
        return false;
    const bool twice = strcmp(o->field, whole) == 0;
    memcpy(o->field, whole, (size_t)length + 1);
    return twice;
}

static bool list_recent(view_open *o)
{
    bool chosen = false;
    if (o->recent.count > 0)
        stp_ui_note("Opened last");
    for (size_t i = 0; i < o->recent.count; i++) {
        stp_ui_push_id((int)i);
        if (stp_ui_item(o->recent.paths[i], strcmp(o->field, o->recent.paths[i]) == 0))
            chosen = press(o, "", o->recent.paths[i]);
        stp_ui_pop_id();
    }
    if (o->recent.count > 0)
        stp_ui_space();
    return chosen;
}

/* Returns whether a file was chosen. */
static bool list_folder(view_open *o)
{
    char to[VIEW_PATH_BYTES + 8] = "";
    bool chosen = false;
    stp_ui_note(o->path);
    if (o->path[1] != '\0' && stp_ui_item("../", false))
        snprintf(to, sizeof to, "%s/..", o->path);
    for (size_t i = 0; i < o->folder.count; i++) {
        const char *name = o->folder.names[i];
        stp_ui_push_id(1000 + (int)i);
        if (stp_ui_item(name, false)) {
            const bool twice = press(o, o->path, name);
            if (view_folder_is_sub(name))
                snprintf(to, sizeof to, "%s", o->field);
            else
                chosen = twice;
        }
        stp_ui_pop_id();
    }
    if (o->why[0] != '\0')
        stp_ui_note(o->why);
    if (to[0] != '\0')
        enter(o, to);
    return chosen;
}

/* The buttons, and Enter in the field. A folder is entered first. */
static view_open_choice ask(view_open *o, bool entered)
{
    stp_ui_disable_begin(o->field[0] == '\0');
    const bool instead = stp_ui_button("open") || entered;
    stp_ui_same_line();
    const bool beside = stp_ui_button("add to the scene");
    stp_ui_disable_end();
    stp_ui_same_line();
    const bool whole = stp_ui_button("open all scans of this folder");
    stp_ui_space();
    if (whole)
        memcpy(o->field, o->path, sizeof o->path);
    else if ((instead || beside) && is_folder(o->field)) {
        enter(o, o->field);
        return VIEW_OPEN_NOTHING;
    }
    if (o->field[0] == '\0')
        return VIEW_OPEN_NOTHING;
    return instead || whole ? VIEW_OPEN_INSTEAD : beside ? VIEW_OPEN_BESIDE : VIEW_OPEN_NOTHING;
}

void view_open_draw(view_open *o, double width, double height, double scale)
{
    const double margin = MARGIN_PX * scale;
    const stp_ui_rect rect = {margin, margin,
                              fmax(fmin(WIDTH_PX * scale, width - 2.0 * margin), 1.0),
                              fmax(height - 4.0 * margin, 1.0)};
    if (!o->shown)
        return;
    if (stp_ui_dialog_begin("Open a model, a scan or an address", &rect, &o->shown)) {
        if (!o->begun)
            stp_ui_focus_next();
        o->begun = true;
        o->choice = ask(o, stp_ui_line("##path", o->field, sizeof o->field));
        const bool recent = list_recent(o), listed = list_folder(o);
        if (recent || listed)
            o->choice = VIEW_OPEN_INSTEAD;
    }
    stp_ui_panel_end();
    o->shown &= o->choice == VIEW_OPEN_NOTHING;
}

void view_open_clear(view_open *o)
{
    view_folder_clear(&o->folder);
    view_recent_clear(&o->recent);
    *o = (view_open){0};
}
