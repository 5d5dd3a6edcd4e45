/* Draws marks over the picture: pivot, clip box and its handles, measured lines, status line, help.
 */
#include "tools/view/panels/view_marks.h"

#include "tools/view/kept/view_marked_show.h"
#include "tools/view/panels/view_legend.h"
#include "tools/view/panels/view_profile_show.h"
#include "tools/view/view_keys.h"
#include "tools/view/view_say.h"

#include <stdio.h>
#include <string.h>

#define WHITE 0xffffffffu
#define DIM 0xc8ccd4ffu
#define ORANGE 0xffb347ffu
#define BLUE 0x61bdebffu
/* Unscaled pixels. */
#define HANDLE_PX 6.0
#define HANDLE_REACH_PX 11.0

/* Draws a line between two places of the model, clipped at the near plane. */
static void world_line(const viewer *v, stp_dvec3 a, stp_dvec3 b, uint32_t colour, double width)
{
    const stp_view *view = &v->control.view;
    a = stp_exaggerated(&v->control.params, a);
    b = stp_exaggerated(&v->control.params, b);
    double near_depth = 2.0 * view->near_depth, from[2], to[2];
    double za = stp_dvec3_dot(stp_dvec3_sub(view->eye, a), view->back);
    double zb = stp_dvec3_dot(stp_dvec3_sub(view->eye, b), view->back);
    if (za < near_depth && zb < near_depth)
        return;
    stp_dvec3 d = stp_dvec3_sub(b, a);
    if (za < near_depth)
        a = stp_dvec3_add(a, stp_dvec3_scale(d, (near_depth - za) / (zb - za)));
    else if (zb < near_depth)
        b = stp_dvec3_add(a, stp_dvec3_scale(d, (za - near_depth) / (za - zb)));
    if (view_place_drawn(v, a, from) && view_place_drawn(v, b, to))
        stp_ui_draw_line(from[0], from[1], to[0], to[1], colour, width * stp_ui_scale(v->ui));
}

static void draw_pivot(const viewer *v)
{
    const view_control *c = &v->control;
    double at[2], s = stp_ui_scale(v->ui);
    if ((c->drag != VIEW_TURN || !c->moved) && !(c->pivot_until_s > v->now_s))
        return;
    if (!view_place_drawn(v, c->pivot, at))
        return;
    stp_ui_draw_circle(at[0], at[1], 7.0 * s, 0x00000080, 4.0 * s);
    stp_ui_draw_circle(at[0], at[1], 7.0 * s, ORANGE, 2.0 * s);
    stp_ui_draw_disc(at[0], at[1], 2.0 * s, ORANGE);
}

/* ---- clip box ---- */

static double *side_of(stp_dbox *box, int face)
{
    double *const sides[6] = {&box->min.x, &box->max.x, &box->min.y,
                              &box->max.y, &box->min.z, &box->max.z};
    return sides[face];
}

static stp_dvec3 axis_of(int face)
{
    return (stp_dvec3){face / 2 == 0, face / 2 == 1, face / 2 == 2};
}

static stp_dvec3 face_middle(stp_dbox box, int face)
{
    stp_dvec3 middle = stp_dvec3_scale(stp_dvec3_add(box.min, box.max), 0.5);
    double *const at[3] = {&middle.x, &middle.y, &middle.z};
    *at[face / 2] = *side_of(&box, face);
    return middle;
}

static void draw_clip(const viewer *v)
{
    const stp_clip *clip = &v->control.params.clip;
    double s = stp_ui_scale(v->ui);
    if (!clip->enabled || !v->panels)
        return;
    for (int i = 0; i < 8; i++)
        for (int k = 1; k < 8; k *= 2) {
            int j = i | k;
            const stp_dvec3 lo = clip->box.min, hi = clip->box.max;
            stp_dvec3 a = {i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z};
            stp_dvec3 b = {j & 1 ? hi.x : lo.x, j & 2 ? hi.y : lo.y, j & 4 ? hi.z : lo.z};
            if (i != j)
                world_line(v, a, b, 0x61bdeba0, 1.3);
        }
    for (int face = 0; face < 6; face++) {
        double at[2];
        if (!view_place(v, face_middle(clip->box, face), at))
            continue;
        stp_ui_draw_disc(at[0], at[1], (HANDLE_PX + 1.5) * s, 0x000000a0);
        stp_ui_draw_disc(at[0], at[1], HANDLE_PX * s, face == v->clip.face ? ORANGE : BLUE);
    }
}

void view_clip_toggle(viewer *v)
{
    stp_clip *clip = &v->control.params.clip;
    clip->enabled = !clip->enabled;
    stp_dvec3 size = stp_dvec3_sub(clip->box.max, clip->box.min);
    if (clip->enabled && !(size.x > 0.0 && size.y > 0.0 && size.z > 0.0))
        clip->box = v->scene.box;
    v->control.changed = true;
}

/* Finds the place on a face's axis that is nearest to the ray through a pixel. The axis goes
 * through the face's middle. False if the ray is along the axis. */
static bool along_axis(const viewer *v, int face, double x, double y, double *out)
{
    const view_control *c = &v->control;
    stp_dvec3 axis = axis_of(face);
    stp_dvec3 middle = stp_exaggerated(&c->params, face_middle(c->params.clip.box, face));
    stp_dvec3 begin = stp_view_unproject(&c->view, x, y, 0.0);
    stp_dvec3 ray = stp_dvec3_sub(stp_view_unproject(&c->view, x, y, 1.0), begin);
    stp_dvec3 w = stp_dvec3_sub(middle, begin);
    ray = stp_dvec3_normalize(ray);
    double b = stp_dvec3_dot(axis, ray), d = stp_dvec3_dot(axis, w), e = stp_dvec3_dot(ray, w);
    if (1.0 - b * b < 1e-3)
        return false;
    middle = stp_dvec3_add(middle, stp_dvec3_scale(axis, (b * e - d) / (1.0 - b * b)));
    *out = stp_dvec3_dot(stp_unexaggerated(&c->params, middle), axis);
    return true;
}

static int face_under(const viewer *v, double x, double y)
{
    int nearest = -1;
    double reach = HANDLE_REACH_PX * stp_ui_scale(v->ui);
    for (int face = 0; face < 6; face++) {
        double at[2];
        if (!view_place(v, face_middle(v->control.params.clip.box, face), at))
            continue;
        double distance = hypot(at[0] - x, v->layout.height - at[1] - y);
        if (distance < reach) {
            reach = distance;
            nearest = face;
        }
    }
    return nearest;
}

bool view_clip_handle(viewer *v, const stp_window_event *e)
{
    stp_dbox *box = &v->control.params.clip.box;
    double along = 0.0;
    if (e->kind == STP_WINDOW_PRESS && e->button == STP_WINDOW_LEFT && v->clip.face < 0 &&
        v->control.params.clip.enabled && v->panels) {
        int face = face_under(v, e->x, e->y);
        if (face < 0 || !along_axis(v, face, e->x, e->y, &along))
            return false;
        v->clip = (view_clip){face, along - *side_of(box, face)};
        return true;
    }
    if (v->clip.face < 0)
        return false;
    if (e->kind == STP_WINDOW_RELEASE)
        v->clip.face = -1;
    if (e->kind != STP_WINDOW_MOVE)
        return e->kind == STP_WINDOW_RELEASE;
    if (along_axis(v, v->clip.face, e->x, e->y, &along)) {
        bool high = v->clip.face % 2 != 0;
        double other = *side_of(box, v->clip.face ^ 1), wanted = along - v->clip.offset;
        *side_of(box, v->clip.face) = high ? fmax(wanted, other) : fmin(wanted, other);
        v->control.changed = true;
    }
    return true;
}

/* ---- measured lines ---- */

/* Gets the window position, too. False if it is behind the eye. */
static bool draw_point(const viewer *v, stp_dvec3 point, double at[2])
{
    double s = stp_ui_scale(v->ui);
    if (!view_place(v, point, at))
        return false;
    stp_ui_draw_disc(at[0], at[1], 5.0 * s, 0x000000a0);
    stp_ui_draw_disc(at[0], at[1], 3.5 * s, ORANGE);
    return true;
}

/* Draws a line with its ends and its length. */
static void draw_measured(const viewer *v, const stp_dvec3 ends[2])
{
    double at[2][2];
    char text[96];
    world_line(v, ends[0], ends[1], ORANGE, 2.0);
    bool first = draw_point(v, ends[0], at[0]), second = draw_point(v, ends[1], at[1]);
    if (!first || !second)
        return;
    view_format_length(v, view_measure_length(ends), VIEW_UNIT_ANY, text);
    stp_ui_draw_label(0.5 * (at[0][0] + at[1][0]),
                      0.5 * (at[0][1] + at[1][1]) - 14.0 * stp_ui_scale(v->ui), text, WHITE, true);
}

/* Draws all lines. A line that was begun ends under the cursor. */
static void draw_measure(const viewer *v)
{
    const view_measure *m = &v->measure;
    const stp_dvec3 begun[2] = {m->first, v->under.position};
    double at[2];
    for (int i = 0; i < m->line_count; i++)
        draw_measured(v, m->lines[i]);
    if (m->begun && v->control.measuring && v->under.hit)
        draw_measured(v, begun);
    else if (m->begun)
        draw_point(v, begun[0], at);
}

/* ---- text ---- */

/* Says at the top of the picture why chunks do not arrive. Returns the height that this takes. */
static double draw_trouble(const viewer *v, const stp_ui_rect *picture)
{
    char text[640];
    const char *why = stp_renderer_trouble(v->renderer);
    if (why[0] == '\0')
        return 0.0;
    snprintf(text, sizeof text, "Parts of the model cannot be read. The viewer goes on trying.\n%s",
             why);
    return stp_ui_draw_bar(picture, text);
}

/* Says at the top of the picture how far a scan is prepared. Returns the height taken so far. */
static double draw_prepare(const viewer *v, double below)
{
    const double s = stp_ui_scale(v->ui), x = 6.0 * s, line = stp_ui_text_height() + 8.0 * s;
    const double y = below + line + 2.0 * x,
                 width = fmin(260.0 * s, v->layout.picture_width - 2.0 * x);
    char text[VIEW_PREPARE_LINE];
    if (!view_prepare_text(&v->prepare, text))
        return below;
    stp_ui_draw_label(x, below + x, text, ORANGE, false);
    if (v->prepare.state == VIEW_PREPARE_FAILED)
        return y;
    stp_ui_draw_line(x, y, x + width, y, 0x000000a0, 4.0 * s);
    stp_ui_draw_line(x, y, x + width * v->prepare.done, y, ORANGE, 4.0 * s);
    return y + x;
}

/* below: height that is taken at the top of the picture. */
static void draw_status(const viewer *v, double below)
{
    char text[320], position[160], how[80] = "";
    double line = stp_ui_text_height() + 8.0 * stp_ui_scale(v->ui);
    double x = 6.0 * stp_ui_scale(v->ui), y = v->layout.height - line - x, top = below + x;
    if (v->note[0] != '\0')
        stp_ui_draw_label(x, y - 1.2 * line, v->note, WHITE, false);
    if (!v->panels)
        return;
    if (v->control.measuring && !v->measure.begun)
        stp_ui_draw_label(x, top, "measuring: click the first point, Esc ends it", ORANGE, false);
    else if (v->control.measuring)
        stp_ui_draw_label(x, top, "measuring: click the second point, Esc ends it", ORANGE, false);
    else if (v->record.on)
        stp_ui_draw_label(x, top, "recording the path, Ctrl+R ends it", ORANGE, false);
    if (!v->under.hit) {
        stp_ui_draw_label(x, y, "F1 lists mouse and keys", DIM, false);
        return;
    }
    view_format_position(v, v->under.position, position);
    if (v->under.interpolated)
        snprintf(how, sizeof how, "interpolated, from level %d of the pyramid",
                 v->under.pyramid_level);
    else if (!v->resting && !v->loading)
        snprintf(how, sizeof how, "measured");
    snprintf(text, sizeof text, "%s   %s", position, how);
    stp_ui_draw_label(x, y, text, WHITE, false);
}

#define VIEW_HELP_ROW(keys, what) stp_ui_row(keys, what);

static void help_rows(void)
{
    VIEW_MOUSE_LIST(VIEW_HELP_ROW)
    stp_ui_space();
    VIEW_KEY_LIST(VIEW_HELP_ROW)
}

static void draw_help(viewer *v)
{
    double s = stp_ui_scale(v->ui);
    double width = fmin(620.0 * s, v->layout.width - 20.0 * s);
    double height = fmin(680.0 * s, v->layout.height - 20.0 * s);
    const stp_ui_rect rect = {0.5 * (v->layout.picture_width - width) > 10.0 * s
                                  ? 0.5 * (v->layout.picture_width - width)
                                  : 10.0 * s,
                              0.5 * (v->layout.height - height), width, height};
    if (!v->help)
        return;
    if (stp_ui_dialog_begin("Mouse and keys", &rect, &v->help))
        help_rows();
    stp_ui_panel_end();
}

static void draw_contour_labels(const viewer *v)
{
    for (int i = 0; i < v->labels.count; i++) {
        const view_label *l = &v->labels.items[i];
        double at[2];
        char text[96];
        if (!view_place(v, l->place, at))
            continue;
        view_format_height(v, l->height, text);
        stp_ui_draw_label(at[0], at[1], text, WHITE, true);
    }
}

/* Draws what belongs to one side, within its stripe. */
static stp_status draw_side(viewer *v, stp_error *err)
{
    stp_ui_rect stripe;
    (void)err;
    if (!view_beside_rect(v, &stripe))
        return STP_OK;
    stp_ui_clip_push(&stripe);
    draw_contour_labels(v);
    view_legend_draw(v, stripe.x);
    stp_ui_clip_pop();
    return STP_OK;
}

void view_marks_draw(viewer *v)
{
    const stp_ui_rect picture = {0.0, v->layout.height - v->layout.picture_height,
                                 v->layout.picture_width, v->layout.picture_height};
    stp_ui_clip_push(&picture);
    (void)view_beside_both(v, draw_side, NULL);
    draw_clip(v);
    view_marked_draw(v);
    draw_measure(v);
    draw_pivot(v);
    draw_status(v, view_beside_draw(v, draw_prepare(v, draw_trouble(v, &picture))));
    view_profile_draw(v);
    stp_ui_clip_pop();
    draw_help(v);
    view_open_draw(&v->dialog, v->layout.picture_width, v->layout.picture_height,
                   stp_ui_scale(v->ui));
}
