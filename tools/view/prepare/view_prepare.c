/* Opens scans in the viewer: kept models, coarse ones, whole ones. */
#include "tools/view/prepare/view_prepare.h"

#include "base/memory.h"
#include "formats/attribute/where.h"
#include "formats/scan/scan.h"
#include "tools/open/open_draft.h"
#include "tools/prep/prep_paths.h"
#include "tools/view/view_say.h"
#include "tools/view/view_wishes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* A larger scan is not read before the window closes. */
#define CHECKED_BYTES (64 << 20)
/* What a server may take to show that a model is there. */
#define CHECK_TIMEOUT_S 10.0

/* Puts an open model into the scene and gives the scene to the renderer, if there is one yet. The
 * model is the scene's from here on. */
static stp_status show(viewer *v, const char *path, stp_model **model, stp_error *err)
{
    stp_status status = STP_OK;
    stp_model *old = NULL;
    STP_TRY(view_scene_put(&v->scene, path, model, &old, err));
    if (v->renderer) {
        v->had_models = VIEW_MODELS_LIMIT; /* the renderer knows other models */
        status = view_scene_changed(v, err);
    }
    if (status != STP_OK && old) /* the coarse model stays */
        (void)view_scene_put(&v->scene, path, &old, model, NULL);
    else if (status != STP_OK)
        view_scene_remove(&v->scene, v->scene.count - 1);
    view_ground_forget(&v->ground, old);
    if (old != NULL)
        view_profile_forget(&v->profile, old->file);
done:
    stp_model_close(&old);
    return status;
}

/* coarse: a draft, which has no attributes, and only chosen points. */
static stp_status show_file(viewer *v, const char *file, const char *path, bool coarse,
                            stp_error *err)
{
    stp_model *model = NULL;
    stp_status status = stp_model_open_at(&model, file, NULL, err);
    if (status == STP_OK && !coarse) {
        const stp_status shown = draw_options_show(v->options, model, err);
        status = v->options->where ? shown : STP_OK;
    }
    if (status == STP_OK)
        status = show(v, path, &model, err);
    stp_model_close(&model);
    return status;
}

/* Whether a condition asks for what only a whole model has. */
static bool asks_outliers(const char *condition)
{
    stp_where where;
    if (!condition || stp_where_parse(&where, condition, NULL) != STP_OK)
        return false;
    for (unsigned i = 0; i < where.name_count; i++)
        if (strcmp(where.names[i], "outlier") == 0)
            return true;
    return false;
}

/* Shows a draft, which has no name from then on. *made: as open_draft_make. */
static stp_status show_draft(viewer *v, const open_scan *scan, const char *path, bool *made,
                             stp_error *err)
{
    stp_status status = STP_OK;
    open_scan coarse = {.params = scan->params};
    STP_TRY(open_scan_take_temporary(&coarse, err));
    if (!asks_outliers(v->options->where))
        status =
            open_draft_make(made, &scan->scans, coarse.path, v->options->where, v->common, err);
    if (status != STP_OK && !(v->options->where && status == STP_UNSUPPORTED)) /* lines */
        goto done;
    status = STP_OK;
    if (*made) {
        status = show_file(v, coarse.path, path, true, err);
        open_scan_opened(&coarse);
    }
done:
    open_scan_clear(&coarse);
    return status;
}

static stp_status copy_arguments(view_prepare *p, const char *const *arguments, size_t count,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&p->arguments, count, sizeof *p->arguments, "arguments", err));
    for (p->count = 0; p->count < count; p->count++)
        STP_TRY(stp_text_copy(&p->arguments[p->count], arguments[p->count], "a path", err));
done:
    return status;
}

static stp_status open_scans(viewer *v, const char *const *arguments, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    view_prepare p = {.left_s = -1.0};
    bool coarse = false;
    const open_scan_params params = draw_options_scan(v->options, "view", v->common);
    if (view_scene_find(&v->scene, arguments[0]) < v->scene.count)
        return stp_error_set(err, STP_EXISTS, "%s: is shown already", arguments[0]);
    STP_TRY(open_scan_find(&p.scan, arguments, count, &params, err));
    if (p.scan.found && show_file(v, p.scan.path, arguments[0], false, NULL) == STP_OK) {
        open_scan_opened(&p.scan);
        goto done;
    }
    if (v->prepare.state == VIEW_PREPARE_WAITING || v->prepare.state == VIEW_PREPARE_RUNNING) {
        status = stp_error_set(err, STP_LIMIT, "%s: another scan is being prepared: add it later",
                               arguments[0]);
        goto done;
    }
    STP_TRY(show_draft(v, &p.scan, arguments[0], &coarse, err));
    if (!coarse && !v->window) {
        STP_TRY(open_scan_prepare(&p.scan, err));
        STP_TRY(show_file(v, p.scan.path, arguments[0], false, err));
        open_scan_opened(&p.scan);
        goto done;
    }
    STP_TRY(copy_arguments(&p, arguments, count, err));
    p.state = VIEW_PREPARE_WAITING;
    view_prepare_end(&v->prepare);
    v->prepare = p;
    p = (view_prepare){0};
done:
    view_prepare_end(&p);
    return status;
}

stp_status view_prepare_add(viewer *v, const char *const *paths, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    const char **scans = NULL;
    size_t scan_count = 0;
    STP_TRY(stp_alloc(&scans, count, sizeof *scans, "arguments", err));
    for (size_t i = 0; i < count; i++) {
        bool scan = false;
        STP_TRY(open_scan_is(&scan, paths[i], err));
        if (scan)
            scans[scan_count++] = paths[i];
        else
            STP_TRY(view_scene_add(&v->scene, v->options, paths[i], err));
    }
    if (scan_count > 0)
        STP_TRY(open_scans(v, scans, scan_count, err));
done:
    free(scans);
    return status;
}

stp_status view_prepare_check(const viewer *v, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_model *model = NULL;
    stp_scan *scan = NULL;
    prep_paths paths = {0};
    draw_options options = *v->options;
    struct stat is;
    bool is_scan = false;
    options.timeout_s = CHECK_TIMEOUT_S; /* the window waits */
    STP_TRY(open_scan_is(&is_scan, path, err));
    if (!is_scan) {
        STP_TRY(draw_options_open_model(&options, path, &model, err));
        goto done;
    }
    STP_TRY(prep_paths_add(&paths, path, err));
    if (stat(paths.list[0], &is) == 0 && is.st_size <= CHECKED_BYTES)
        STP_TRY(stp_scan_open(&scan, paths.list[0], NULL, err));
done:
    stp_scan_close(&scan);
    stp_model_close(&model);
    prep_paths_clear(&paths);
    return status;
}

void view_add_models(viewer *v, const char *const *paths, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        stp_error err = {0};
        bool scan = false;
        stp_status status = open_scan_is(&scan, paths[i], &err);
        if (status == STP_OK)
            status = scan ? open_scans(v, &paths[i], 1, &err)
                          : view_scene_add(&v->scene, v->options, paths[i], &err);
        if (status == STP_OK && !scan) {
            status = view_scene_changed(v, &err);
            if (status != STP_OK)
                view_scene_remove(&v->scene, v->scene.count - 1);
        }
        if (status == STP_OK)
            view_recent_note(paths[i]);
        if (status == STP_OK && view_scene_find(&v->scene, paths[i]) == v->scene.count)
            continue; /* it is being prepared */
        if (status == STP_OK)
            view_note(v, "%s was added", v->scene.models[v->scene.count - 1].name);
        else
            view_note(v, "%s", err.message);
    }
}

/* Shows the child's model, or says why there is none. */
static void finish(viewer *v)
{
    view_prepare *p = &v->prepare;
    stp_error err = {0};
    view_prepare_reap(p);
    p->scan.partial = p->why[0] != '\0';
    if (access(p->scan.path, F_OK) == 0) {
        const bool shown = show_file(v, p->scan.path, p->arguments[0], false, &err) == STP_OK;
        if (shown) {
            v->control.wants |= VIEW_WANTS_RANGE;
            view_note(v, "%s", p->scan.partial ? p->why : "the whole model is shown");
        }
        open_scan_opened(&p->scan);
        if (shown) {
            view_prepare_end(p);
            return;
        }
        snprintf(p->why, sizeof p->why, "%s", err.message);
    } else if (p->scan.folder && strncmp(p->why, p->scan.path, strlen(p->scan.path)) == 0) {
        /* the cache's disk is full, perhaps: once more, elsewhere */
        (void)stp_error_set(&err, STP_IO, "%s", p->why);
        if (open_scan_give_up_keeping(&p->scan, &err, NULL) == STP_OK) {
            p->state = VIEW_PREPARE_WAITING;
            return;
        }
    }
    p->state = VIEW_PREPARE_FAILED;
    if (p->why[0] == '\0')
        snprintf(p->why, sizeof p->why, "prep was stopped");
    fprintf(stderr, "stipple view: %s\n", p->why);
}

/* Shows the model if it was kept meanwhile: by the side beside this one, or by another process. */
static bool show_kept(viewer *v)
{
    view_prepare *p = &v->prepare;
    if (!p->scan.folder || access(p->scan.path, F_OK) != 0 ||
        show_file(v, p->scan.path, p->arguments[0], false, NULL) != STP_OK)
        return false;
    open_scan_opened(&p->scan);
    view_prepare_end(p);
    v->control.wants |= VIEW_WANTS_RANGE;
    return true;
}

void view_prepare_turn(viewer *v)
{
    view_prepare *p = &v->prepare;
    char before[VIEW_PREPARE_LINE], after[VIEW_PREPARE_LINE];
    const bool said = view_prepare_text(p, before);
    if (p->state == VIEW_PREPARE_WAITING && v->chart.count > 0 && !v->loading) {
        if (p->scan.found) /* but damaged */
            (void)unlink(p->scan.path);
        if (!show_kept(v))
            view_prepare_start(p, v->common->threads);
        if (p->state == VIEW_PREPARE_FAILED)
            fprintf(stderr, "stipple view: %s\n", p->why);
    } else if (p->state == VIEW_PREPARE_RUNNING && !view_prepare_listen(p)) {
        finish(v);
    }
    if (view_prepare_text(p, after) != said || (said && strcmp(before, after) != 0))
        v->ui_turns = v->ui_turns > 0 ? v->ui_turns : 1;
}
