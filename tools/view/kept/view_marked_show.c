/* Shows marks: pins in the picture, the panel's list; sets marks and goes to them. */
#include "tools/view/kept/view_marked_show.h"

#include "tools/view/panels/view_panels.h"
#include "tools/view/view_say.h"

#include <stdio.h>

#define PIN 0xff5a6effu
#define PIN_HIDDEN 0xff5a6e70u /* the surface lies in front */
#define WHITE 0xffffffffu
#define GREY 0xb8bcc4b0u
/* Unscaled pixels. */
#define STEM_PX 20.0
#define HEAD_PX 5.0
/* A surface hides a mark if it lies this much nearer: pixels of depth, and a share of it. A
 * surface's own depth lies up to its discs' thickness before it. */
#define HIDES_PX 8.0
#define HIDES_SHARE 2e-3
/* Goes to a mark from no farther than this share of the scene's radius. */
#define VISIT 0.3

void view_mark_here(viewer *v)
{
    stp_pick found = {0};
    stp_error err = {0};
    int x = (int)floor(v->control.x), y = (int)floor(v->control.y);
    view_drawn_pixel(v, &x, &y);
    if (v->control.x >= 0.0 && v->control.y >= 0.0)
        stp_renderer_pick(v->renderer, x, y, &found, NULL); /* outside the picture: no hit */
    if (!found.hit) {
        view_note(v, "nothing is under the cursor to mark");
        return;
    }
    if (!view_marked_add(&v->marked, found.position)) {
        view_note(v, "there are %d marks already: remove one", VIEW_MARKED_LIMIT);
        return;
    }
    if (view_marked_save(&v->marked, view_beside_first(v)->models[0].path, &err) == STP_OK)
        view_note(v, "the marks are in %s", v->marked.path);
    else
        view_note(v, "%s", err.message);
}

/* Whether the surface that was drawn hides a place. */
static bool is_hidden(const viewer *v, stp_dvec3 place)
{
    const stp_view *view = &v->control.view;
    const stp_dvec3 w = stp_view_project(view, stp_exaggerated(&v->control.params, place));
    const double pixel = view->orthographic ? 1.0 / view->f : w.z / view->f;
    float depth = 0.0f;
    int x = (int)floor(w.x), y = (int)floor(w.y);
    if (w.x < 0.0 || w.y < 0.0 || w.x >= view->width || w.y >= view->height)
        return false;
    stp_renderer *renderer = view_beside_renderer(v, w.x);
    view_drawn_pixel(v, &x, &y);
    if (stp_renderer_depth_at(renderer, x, y, &depth, NULL) != STP_OK || !(depth > 0.0f))
        return false;
    return (double)depth + HIDES_PX * pixel + HIDES_SHARE * w.z < w.z;
}

void view_marked_draw(viewer *v)
{
    const double s = stp_ui_scale(v->ui);
    v->marks_hidden = 0;
    for (size_t i = 0; i < v->marked.count; i++) {
        const view_mark *mark = &v->marked.items[i];
        double at[2];
        if (!view_place(v, mark->position, at))
            continue;
        const bool hidden = is_hidden(v, mark->position);
        const uint32_t colour = hidden ? PIN_HIDDEN : PIN;
        const double top = at[1] - STEM_PX * s;
        v->marks_hidden += hidden;
        stp_ui_draw_line(at[0], at[1], at[0], top, colour, 2.0 * s);
        if (hidden)
            stp_ui_draw_circle(at[0], top, HEAD_PX * s, colour, 2.0 * s);
        else
            stp_ui_draw_disc(at[0], top, HEAD_PX * s, colour);
        stp_ui_draw_label(at[0] + HEAD_PX * s, top - stp_ui_text_height(), mark->name,
                          hidden ? GREY : WHITE, false);
    }
}

/* Looks at a mark from near, in the same direction; it becomes the pivot. */
static void go_to(viewer *v, const view_mark *mark)
{
    view_control *c = &v->control;
    stp_camera *camera = &c->camera;
    const stp_dvec3 at = stp_exaggerated(&c->params, mark->position);
    const stp_dvec3 away = stp_dvec3_sub(camera->eye, camera->look);
    const double distance = fmin(stp_dvec3_length(away), VISIT * c->ball.radius);
    if (camera->height > 0.0)
        camera->height = fmin(camera->height, 2.0 * VISIT * c->ball.radius);
    camera->eye = stp_dvec3_add(at, stp_dvec3_scale(stp_dvec3_normalize(away), distance));
    camera->look = at;
    c->centre = c->pivot = at;
    c->has_centre = true;
    c->pivot_until_s = v->now_s + VIEW_PIVOT_S;
    c->changed = true;
}

static void save(viewer *v)
{
    stp_error err = {0};
    if (view_marked_save(&v->marked, view_beside_first(v)->models[0].path, &err) != STP_OK)
        view_note(v, "%s", err.message);
}

void view_panel_marks(viewer *v)
{
    size_t removed = VIEW_MARKED_LIMIT;
    for (size_t i = 0; i < v->marked.count; i++) {
        view_mark *mark = &v->marked.items[i];
        char text[160];
        stp_ui_push_id((int)i);
        if (stp_ui_button("go"))
            go_to(v, mark);
        view_format_position(v, mark->position, text);
        stp_ui_hint(text);
        stp_ui_same_line();
        removed = stp_ui_button("x") ? i : removed;
        stp_ui_hint("removes it");
        stp_ui_same_line();
        if (stp_ui_field("##name", mark->name, sizeof mark->name))
            save(v);
        stp_ui_pop_id();
    }
    if (removed < VIEW_MARKED_LIMIT) {
        view_marked_remove(&v->marked, removed);
        save(v);
    }
    stp_ui_note("F marks what is under the cursor.");
    if (v->marked.path[0] != '\0')
        stp_ui_note(v->marked.path);
}
