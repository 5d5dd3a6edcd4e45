/* Fulfils what keys and panels ask for. */
#include "tools/view/view_wishes.h"

#include "runtime/class_legend.h"
#include "tools/draw/draw_exaggerate.h"
#include "tools/view/kept/view_marked_show.h"
#include "tools/view/panels/view_marks.h"
#include "tools/view/panels/view_profile_show.h"
#include "tools/view/view_move.h"
#include "tools/view/view_say.h"

#include <stdio.h>
#include <string.h>

/* Width of the panel, and of a window too narrow for it, in unscaled pixels. */
#define PANEL_WIDTH 330.0

void view_layout_update(viewer *v)
{
    view_layout l = {0};
    stp_window_size(v->window, &l.width, &l.height);
    double panel = v->panels ? floor(PANEL_WIDTH * stp_ui_scale(v->ui)) : 0.0;
    panel = fmin(panel, l.width - 1.0);
    l.picture_width = l.width - (int)fmax(panel, 0.0);
    l.picture_width = l.picture_width > 1 ? l.picture_width : 1;
    l.picture_height = l.height > 1 ? l.height : 1;
    if (panel > 0.0)
        l.panel = (stp_ui_rect){l.picture_width, 0.0, panel, l.height};
    if (l.picture_width != v->layout.picture_width || l.picture_height != v->layout.picture_height)
        v->control.changed = true;
    v->layout = l;
}

static stp_status go_home(viewer *v, stp_error *err)
{
    draw_options o = *v->options;
    stp_status status = STP_OK;
    o.camera.size[0] = v->layout.picture_width;
    o.camera.size[1] = v->layout.picture_height;
    o.camera.has_size = true;
    const int *size = o.camera.size;
    const stp_draw_params *p = &v->control.params;
    const stp_dbox box = draw_exaggerate_box(p, &v->scene.box);
    const bool alone = v->scene.count == 1;
    o.exaggerate = p->exaggerate > 0.0 ? p->exaggerate : 1.0;
    stp_camera camera = alone ? draw_options_start(&o, v->scene.models[0].model, size)
                              : stp_camera_default(&box, &v->control.ball, size[0], size[1]);
    STP_TRY(camera_options_apply(&o.camera, &camera, err));
    v->control.camera = camera;
    v->control.changed = true;
done:
    return status;
}

stp_status view_go_home(viewer *v, stp_error *err)
{
    const int side = view_beside_use(v, 0); /* the start view is the first side's */
    const stp_status status = go_home(v, err);
    view_beside_use(v, side);
    return status;
}

/* Sets the colour range. --colour-range holds only for the colour at the start. */
static stp_status set_range(viewer *v, stp_error *err)
{
    stp_draw_params *p = &v->control.params, first;
    const stp_model *model = v->scene.models[0].model;
    if (v->options->attribute && p->colour == STP_COLOUR_INTENSITY) {
        p->colour_range[0] = 0.0;
        p->colour_range[1] = 1.0;
        return STP_OK;
    }
    if ((int)p->colour == v->options->colour && v->options->colour_range != NULL) {
        stp_status status = draw_options_params(v->options, model, &first, err);
        memcpy(p->colour_range, first.colour_range, sizeof p->colour_range);
        return status;
    }
    if (p->colour != STP_COLOUR_INTENSITY && p->colour != STP_COLOUR_ELEVATION)
        return STP_OK;
    for (size_t i = 0; i < v->scene.count; i++) {
        double range[2];
        stp_status status = stp_model_colour_range(v->scene.models[i].model, p->colour, range, err);
        if (status != STP_OK)
            return status;
        p->colour_range[0] = i > 0 ? fmin(p->colour_range[0], range[0]) : range[0];
        p->colour_range[1] = i > 0 ? fmax(p->colour_range[1], range[1]) : range[1];
    }
    return STP_OK;
}

void view_toggle_record(viewer *v)
{
    char path[VIEW_PATH_BYTES];
    stp_error err = {0};
    if (!v->record.on) {
        view_record_begin(&v->record, v->now_s);
        view_note(v, "recording the camera's path: Ctrl+R ends it");
        return;
    }
    stp_status status = view_files_free(path, v->scene.models[0].name, ".path.json", &err);
    if (status == STP_OK)
        status = view_record_end(&v->record, &v->control.camera, path, v->now_s, &err);
    v->record.on = false;
    if (status == STP_OK)
        view_note(v, "the path is in %s: stipple fly --path makes a film of it", path);
    else
        view_note(v, "%s", err.message);
}

/* The size of the screenshot that the panel asks for, in the window's proportions. */
static void shot_size(const viewer *v, int *width, int *height)
{
    static const int factors[] = {1, 2, 4}, sides[] = {4096, 8192, VIEW_SHOT_LIMIT};
    int w = v->layout.picture_width, h = v->layout.picture_height, longer = w > h ? w : h;
    double factor =
        v->shot_size < 3 ? factors[v->shot_size] : (double)sides[v->shot_size - 3] / longer;
    factor = fmin(factor, (double)VIEW_SHOT_LIMIT / longer);
    *width = (int)fmax(1.0, floor(w * factor + 0.5));
    *height = (int)fmax(1.0, floor(h * factor + 0.5));
}

void view_begin_shot(viewer *v)
{
    char path[VIEW_PATH_BYTES];
    int width = 0, height = 0;
    stp_view view;
    stp_error err = {0};
    stp_status status = STP_OK;
    if (v->shot.state == VIEW_SHOT_DRAWING || v->shot.state == VIEW_SHOT_WRITING)
        return;
    shot_size(v, &width, &height);
    view_shot_end(&v->shot);
    STP_TRY(view_files_free(path, v->scene.models[0].name, ".png", &err));
    STP_TRY(stp_view_create(&view, &v->control.camera, &v->control.ball, width, height, &err));
    STP_TRY(view_shot_begin(&v->shot, &view, path, &err));
done:
    if (status != STP_OK)
        view_note(v, "%s", err.message);
}

/* Shows a note when a screenshot was written. */
static void poll_shot(viewer *v)
{
    stp_error err = {0};
    stp_status status = view_shot_poll(&v->shot, &err);
    if (v->shot.state == VIEW_SHOT_WRITTEN)
        view_note(v, "%s: %d x %d pixels", v->shot.path, v->shot.image.width, v->shot.image.height);
    else if (status != STP_OK)
        view_note(v, "%s", err.message);
    if (v->shot.state == VIEW_SHOT_WRITTEN || v->shot.state == VIEW_SHOT_FAILED)
        view_shot_end(&v->shot);
}

void view_save_bookmarks(viewer *v)
{
    stp_error err = {0};
    if (view_bookmarks_save(&v->bookmarks, view_beside_first(v)->models[0].path, &err) == STP_OK)
        view_note(v, "the views are in %s", v->bookmarks.path);
    else
        view_note(v, "%s", err.message);
}

void view_keep(viewer *v)
{
    if (view_bookmarks_add(&v->bookmarks, &v->control.camera))
        view_save_bookmarks(v);
    else
        view_note(v, "there are %d views already: remove one", VIEW_BOOKMARKS_LIMIT);
}

void view_recall(viewer *v, size_t index)
{
    if (index >= v->bookmarks.count) {
        view_note(v, "no view %zu was kept: B keeps one", index + 1);
        return;
    }
    v->control.camera = v->bookmarks.items[index].camera;
    v->control.changed = true;
    view_note(v, "%s", v->bookmarks.items[index].name);
}

static void wake(void *context)
{
    (void)context;
    stp_window_wake();
}

/* Finds which colours and classes exist. */
static void survey(viewer *v)
{
    view_control *c = &v->control;
    c->colours = 1u << STP_COLOUR_RGB | 1u << STP_COLOUR_NONE | 1u << STP_COLOUR_ELEVATION |
                 1u << STP_COLOUR_FIT;
    c->colours |= v->scene.attributes & STP_HAS_INTENSITY || v->options->attribute
                      ? 1u << STP_COLOUR_INTENSITY
                      : 0;
    c->colours |= v->scene.attributes & STP_HAS_CLASS ? 1u << STP_COLOUR_CLASS : 0;
    c->colours |= v->scene.attributes & STP_HAS_OUTLIERS ? 1u << STP_COLOUR_OUTLIERS : 0;
    memset(v->model_classes, 0, sizeof v->model_classes);
    for (size_t i = 0; i < v->scene.count; i++) {
        uint32_t classes[8] = {0};
        if (v->scene.models[i].model->info->attributes & STP_HAS_CLASS)
            stp_model_classes(v->scene.models[i].model, classes, NULL); /* on failure: none */
        for (int k = 0; k < 8; k++)
            v->model_classes[k] |= classes[k];
    }
}

void view_ball_changed(viewer *v)
{
    const stp_dbox *own = &v->scene.box, box = view_beside_box(v);
    const bool all = stp_dvec3_length(stp_dvec3_sub(box.max, box.min)) ==
                     stp_dvec3_length(stp_dvec3_sub(own->max, own->min));
    const stp_ball ball = all ? v->scene.ball : stp_ball_from_box(&box);
    v->control.ball = draw_exaggerate_ball(&v->control.params, &ball, &box);
}

void view_exaggerate(viewer *v, double times)
{
    view_control *c = &v->control;
    const stp_draw_params before = c->params;
    draw_exaggerate_set(&c->params, times > 0.0 ? times : 1.0, &view_beside_first(v)->box);
    draw_exaggerate_camera(&c->params, &before, &c->camera);
    c->centre = stp_exaggerated(&c->params, stp_unexaggerated(&before, c->centre));
    c->pivot = stp_exaggerated(&c->params, stp_unexaggerated(&before, c->pivot));
    c->changed = true;
    view_ball_changed(v);
}

/* Gives the renderer all models, or all except one. */
static stp_status set_models(viewer *v, size_t without, stp_error *err)
{
    const stp_model *models[VIEW_MODELS_LIMIT];
    size_t count = 0;
    for (size_t i = 0; i < v->scene.count; i++)
        if (i != without)
            models[count++] = v->scene.models[i].model;
    return stp_renderer_set_models(v->renderer, models, count, err);
}

stp_status view_scene_changed(viewer *v, stp_error *err)
{
    stp_status status = STP_OK;
    if (v->renderer == NULL) {
        stp_renderer_params params =
            draw_options_renderer(v->options, v->scene.models[0].model, v->common);
        params.wake = wake;
        STP_TRY(stp_renderer_create(&v->renderer, &params, err));
    }
    if (v->scene.count > 1 || v->had_models > 1)
        STP_TRY(set_models(v, VIEW_MODELS_LIMIT, err));
    v->had_models = v->scene.count;
    v->control.changed = true;
    view_exaggerate(v, v->control.params.exaggerate); /* its middle may be another */
    survey(v);
done:
    return status;
}

void view_remove_model(viewer *v, size_t index)
{
    stp_error err = {0};
    if (v->scene.count < 2)
        return;
    if (set_models(v, index, &err) != STP_OK) {
        view_note(v, "%s", err.message);
        return;
    }
    view_ground_forget(&v->ground, v->scene.models[index].model);
    view_profile_forget(&v->profile, v->scene.models[index].model->file);
    view_scene_remove(&v->scene, index);
    v->had_models = v->scene.count;
    v->model_open = 0;
    v->control.changed = true;
    view_exaggerate(v, v->control.params.exaggerate);
    survey(v);
}

/* Ends the innermost thing that is going on. */
static void escape(viewer *v)
{
    view_control *c = &v->control;
    if (v->shot.state == VIEW_SHOT_DRAWING)
        view_shot_end(&v->shot);
    else if (v->help)
        v->help = false;
    else if (v->dialog.shown)
        v->dialog.shown = false;
    else if (view_profile_close(v))
        ; /* its chart is gone */
    else if (c->measuring && v->measure.begun)
        v->measure.begun = false;
    else if (c->measuring)
        c->measuring = false;
    else if (c->navigation != VIEW_ORBIT)
        view_control_navigate(c, VIEW_ORBIT);
    else if (stp_window_is_full_screen(v->window))
        stp_window_set_full_screen(v->window, false);
    else
        v->quits = true;
    c->changed = true;
}

/* Handles a click: finds what is there, and adds a point to the measured line. */
static void pick(viewer *v)
{
    const double *at = v->control.click;
    stp_pick found = {0};
    int x = (int)floor(at[0]), y = (int)floor(at[1]);
    view_drawn_pixel(v, &x, &y);
    stp_renderer_pick(v->renderer, x, y, &found, NULL);
    v->clicked = found;
    v->values.count = 0;
    if (v->scene.count == 1)
        view_values_find(&v->values, v->scene.models[0].model, &found);
    if (!v->control.measuring)
        return;
    if (!found.hit) {
        view_note(v, "nothing is there to measure");
        return;
    }
    if (!view_measure_add(&v->measure, found.position))
        view_note(v, "there are %d measured lines already: remove one in the panel",
                  VIEW_LINES_LIMIT);
}

stp_status view_fulfil(viewer *v, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t wants = v->control.wants;
    v->control.wants = 0;
    view_beside_link(v);
    poll_shot(v);
    view_profile_turn(v);
    if (wants & VIEW_WANTS_QUIT)
        v->quits = true;
    if (wants & VIEW_WANTS_ESCAPE)
        escape(v);
    if (wants & VIEW_WANTS_HOME)
        STP_TRY(view_go_home(v, err));
    if (wants & VIEW_WANTS_RANGE) {
        STP_TRY(view_beside_both(v, set_range, err));
        view_beside_join_ranges(v);
    }
    if (wants & VIEW_WANTS_PICK)
        pick(v);
    if (wants & VIEW_WANTS_MARK)
        view_mark_here(v);
    if (wants & VIEW_WANTS_PROFILE)
        view_profile_last(v);
    if (wants & VIEW_WANTS_SHOT)
        view_begin_shot(v);
    if (wants & VIEW_WANTS_RECORD)
        view_toggle_record(v);
    if (wants & VIEW_WANTS_KEEP)
        view_keep(v);
    if (wants & VIEW_WANTS_RECALL)
        view_recall(v, (size_t)v->control.recall);
    if (wants & VIEW_WANTS_PANELS)
        v->panels = v->panels_wanted = !v->panels;
    if (wants & VIEW_WANTS_HELP)
        v->help = !v->help;
    if (wants & VIEW_WANTS_FULL_SCREEN)
        stp_window_set_full_screen(v->window, !stp_window_is_full_screen(v->window));
    if (wants & VIEW_WANTS_OPEN)
        view_open_begin(&v->dialog, v->scene.models[0].path);
    if (wants & VIEW_WANTS_CLIP)
        view_clip_toggle(v);
    if (wants != 0)
        v->ui_turns = VIEW_TURNS_TO_SETTLE;
done:
    return status;
}
