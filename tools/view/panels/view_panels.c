/* Draws the panel at the right: its sections; models, camera, and frames and memory. */
#include "tools/view/panels/view_panels.h"

#include "base/earth.h"
#include "tools/view/view_move.h"
#include "tools/view/view_say.h"
#include "tools/view/view_wishes.h"

#include <stdio.h>
#include <string.h>

/* Formats 1234567 as "1,234,567". */
static void format_count(uint64_t count, char out[32])
{
    char digits[24];
    int length = snprintf(digits, sizeof digits, "%llu", (unsigned long long)count), at = 0;
    for (int i = 0; i < length; i++) {
        if (i > 0 && (length - i) % 3 == 0)
            out[at++] = ',';
        out[at++] = digits[i];
    }
    out[at] = '\0';
}

static void format_bytes(uint64_t bytes, char out[32])
{
    static const char *const units[] = {"bytes", "KiB", "MiB", "GiB", "TiB"};
    double value = (double)bytes;
    int unit = 0;
    for (; value >= 1024.0 && unit < 4; unit++)
        value /= 1024.0;
    snprintf(out, 32, value < 10.0 && unit > 0 ? "%.2f %s" : "%.0f %s", value, units[unit]);
}

/* ---- models ---- */

static void attributes_text(uint32_t attributes, char out[64])
{
    snprintf(out, 64, "normal%s%s%s%s%s%s", attributes & STP_HAS_COLOUR ? ", colour" : "",
             attributes & STP_HAS_INTENSITY ? ", intensity" : "",
             attributes & STP_HAS_CLASS ? ", class" : "",
             attributes & STP_HAS_OUTLIERS ? ", outliers" : "",
             attributes & STP_HAS_LINES ? ", lines" : "",
             attributes & STP_HAS_TRIANGLES ? ", triangles" : "");
}

static void model_rows(const viewer *v, const view_model *m)
{
    const stp_chunk_file_info *info = m->model->info;
    stp_dvec3 size = stp_dvec3_sub(info->box.max, info->box.min);
    char text[160], count[32];
    format_count(info->point_count, count);
    stp_ui_row("points", count);
    snprintf(text, sizeof text, "%.5g x %.5g x %.5g", size.x, size.y, size.z);
    stp_ui_row("size", text);
    view_format_position(v, info->box.min, text);
    stp_ui_row("from", text);
    view_format_position(v, info->box.max, text);
    stp_ui_row("to", text);
    attributes_text(info->attributes, text);
    stp_ui_row("attributes", text);
    if (m->sources[0] != '\0')
        stp_ui_row("made of", m->sources);
    if (m->system[0] != '\0')
        stp_ui_row("system", m->system);
}

void view_panel_models(viewer *v)
{
    for (size_t i = 0; i < v->scene.count; i++) {
        view_model *m = &v->scene.models[i];
        bool shown = !m->hidden;
        stp_ui_push_id((int)i);
        if (v->scene.count > 1) {
            if (stp_ui_check(m->name, &shown)) {
                m->hidden = !shown;
                view_scene_update(&v->scene);
                view_ball_changed(v);
                v->control.changed = true;
            }
            stp_ui_same_line();
            if (stp_ui_button("remove"))
                v->removing = (int)i; /* removed after this frame */
        } else {
            stp_ui_text(m->name);
        }
        if (v->scene.count == 1 || (int)i == v->model_open)
            model_rows(v, m);
        else if (stp_ui_button("more"))
            v->model_open = (int)i;
        stp_ui_pop_id();
    }
    if (stp_ui_button("open..."))
        v->control.wants |= VIEW_WANTS_OPEN;
    stp_ui_note("Or drop a file here: it is added to the scene.");
}

/* ---- camera ---- */

static void navigation_rows(viewer *v)
{
    view_control *c = &v->control;
    int navigation = (int)c->navigation;
    double unit = pow(10.0, -view_digits(v));
    if (stp_ui_radio(&navigation, VIEW_NAVIGATIONS, ~0u))
        view_control_navigate(c, (view_navigation)navigation);
    stp_ui_hint("orbit: about a pivot; fly: W A S D Q E; walk: likewise, on the ground");
    if (c->navigation == VIEW_ORBIT)
        return;
    stp_ui_slider("speed", &c->speed, VIEW_SPEED_LEAST * c->ball.radius + unit,
                  VIEW_SPEED_MOST * c->ball.radius, "%.3g", true);
    if (c->navigation == VIEW_WALK && stp_ui_number("eye height", &c->eye_height, "%.3f"))
        c->eye_height = fmax(c->eye_height, unit);
}

static void facing_rows(viewer *v)
{
    static const char *const names[] = {"front", "back", "left", "right", "top", "bottom"};
    const bool z_up = v->control.camera.up.z > 0.5;
    const double y = v->control.camera.up.y < -0.5 ? -1.0 : 1.0;
    const stp_dvec3 whole = stp_model_camera(v->scene.models[0].model, STP_HOME_WHOLE, 1, 1).up;
    const stp_dvec3 axis = z_up ? (stp_dvec3){0.0, 0.0, 1.0} : (stp_dvec3){0.0, y, 0.0};
    const stp_dvec3 up = stp_up_is_axis(whole) ? axis : whole;
    const stp_dvec3 front = stp_front(up);
    const stp_dvec3 right = stp_dvec3_cross(up, front);
    /* the view from above is tilted a little to the front, so that up stays up */
    const stp_dvec3 tilt = stp_dvec3_scale(front, 1e-3);
    const stp_dvec3 directions[] = {
        front, stp_dvec3_scale(front, -1.0), stp_dvec3_scale(right, -1.0),
        right, stp_dvec3_add(up, tilt),      stp_dvec3_sub(tilt, up)};
    for (int i = 0; i < 6; i++) {
        if (i % 3 != 0)
            stp_ui_same_line();
        if (stp_ui_button(names[i]))
            view_control_face(&v->control, directions[i], up);
    }
    stp_ui_same_line();
    if (stp_ui_button("home"))
        v->control.wants |= VIEW_WANTS_HOME;
}

void view_panel_camera(viewer *v)
{
    view_control *c = &v->control;
    char text[160];
    int projection = c->camera.height > 0.0;
    navigation_rows(v);
    if (stp_ui_radio(&projection, "perspective|orthographic",
                     c->navigation == VIEW_ORBIT ? ~0u : 1u))
        view_control_project(c, projection != 0);
    if (projection == 0 &&
        stp_ui_slider("angle", &c->camera.fovy_deg, 5.0, 120.0, "%.0f degrees", false))
        c->changed = true;
    facing_rows(v);
    view_format_position(v, c->camera.eye, text);
    stp_ui_row("eye", text);
    if (c->has_centre) {
        view_format_position(v, c->centre, text);
        stp_ui_row("pivot", text);
        if (stp_ui_button("forget the pivot"))
            c->has_centre = false;
    } else {
        stp_ui_row("pivot", "what is under the cursor");
    }
}

/* ---- frames and memory ---- */

static float greatest(const float *values, int count)
{
    float most = 0.0f;
    for (int i = 0; i < count; i++)
        most = values[i] > most ? values[i] : most;
    return most > 0.0f ? 1.15f * most : 1.0f;
}

void view_panel_numbers(viewer *v)
{
    const view_chart *chart = &v->chart;
    const stp_draw_stats stats = view_beside_stats(v);
    char text[160], count[32], bytes[32];
    int first = chart->count == VIEW_HISTORY ? chart->next : 0;
    snprintf(text, sizeof text, "%.1f ms a frame", stats.frame_ms);
    stp_ui_chart(text, chart->frame_ms, chart->count, first,
                 greatest(chart->frame_ms, chart->count));
    format_count(stats.points_drawn, count);
    snprintf(text, sizeof text, "%s points", count);
    stp_ui_chart(text, chart->points, chart->count, first, greatest(chart->points, chart->count));
    snprintf(text, sizeof text, "%u drawn, %u missing", stats.chunks_drawn, stats.chunks_missing);
    stp_ui_row("chunks", text);
    stp_memory_use use = stp_renderer_memory(v->renderer);
    char used[32];
    format_bytes(use.gpu_used, used);
    format_bytes(use.gpu_allotted, bytes);
    snprintf(text, sizeof text, "%s of %s", used, bytes);
    stp_ui_row("GPU memory", text);
    format_bytes(use.cpu_allotted, bytes);
    stp_ui_row("CPU memory", bytes);
    format_bytes(stp_renderer_bytes_read(v->renderer), bytes);
    stp_ui_row("read so far", bytes);
}

/* ---- all ---- */

void view_panels_draw(viewer *v)
{
    static const struct {
        const char *title;
        void (*draw)(viewer *v);
    } sections[VIEW_SECTION_COUNT] = {
#define X(name, draw, title, open) {title, draw},
        VIEW_SECTION_LIST(X)
#undef X
    };
    const int first = v->beside.other.options != NULL ? 0 : VIEW_SECTION_BESIDE + 1;
    if (stp_ui_panel_begin("panel", &v->layout.panel))
        for (int i = first; i < VIEW_SECTION_COUNT; i++) {
            stp_ui_push_id(i);
            if (stp_ui_section(sections[i].title, &v->open[i])) {
                sections[i].draw(v);
                stp_ui_space();
            }
            stp_ui_pop_id();
        }
    stp_ui_panel_end();
}
