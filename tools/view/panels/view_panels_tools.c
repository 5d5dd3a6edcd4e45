/* Draws the panel's sections with tools: clip box, measuring, kept views and path, screenshot. */
#include "tools/view/panels/view_legend.h"
#include "tools/view/panels/view_marks.h"
#include "tools/view/panels/view_panels.h"
#include "tools/view/view_say.h"
#include "tools/view/view_wishes.h"

#include <stdio.h>
#include <string.h>

#define ALL 0xffffffffu

void view_panel_clip(viewer *v)
{
    stp_clip *clip = &v->control.params.clip;
    bool enabled = clip->enabled;
    char format[16];
    stp_dbox box = clip->box;
    double low[3] = {box.min.x, box.min.y, box.min.z}, high[3] = {box.max.x, box.max.y, box.max.z};
    if (stp_ui_check("draw only what is inside", &enabled))
        view_clip_toggle(v);
    if (!clip->enabled)
        return;
    snprintf(format, sizeof format, "%%.%df", view_digits(v));
    stp_ui_note("from x, y, z");
    bool changed = stp_ui_numbers("low", low, format);
    stp_ui_note("to x, y, z");
    changed |= stp_ui_numbers("high", high, format);
    for (int i = 0; i < 3; i++)
        high[i] = fmax(low[i], high[i]);
    if (changed) {
        clip->box = (stp_dbox){{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
        v->control.changed = true;
    }
    if (stp_ui_button("the whole scene")) {
        clip->box = v->scene.box;
        v->control.changed = true;
    }
    stp_ui_note("The handles in the picture move the faces.");
}

/* Copies both ends of each line, a point a row. */
static void copy_measure(viewer *v)
{
    const view_measure *m = &v->measure;
    char text[VIEW_LINES_LIMIT * 160] = "";
    size_t length = 0;
    for (int i = 0; i < 2 * m->line_count; i++) {
        const stp_dvec3 p = m->lines[i / 2][i % 2];
        length += (size_t)snprintf(text + length, sizeof text - length, "%.17g %.17g %.17g\n", p.x,
                                   p.y, p.z);
    }
    stp_window_copy_text(v->window, text);
    view_note(v, "the coordinates were copied");
}

static void distance_rows(const viewer *v, const stp_dvec3 ends[2])
{
    stp_dvec3 d = stp_dvec3_sub(ends[1], ends[0]);
    stp_dvec3 up = stp_dvec3_normalize(v->control.camera.up);
    double rise = stp_dvec3_dot(d, up), length = stp_dvec3_length(d);
    char text[224], level[96], high[96];
    int digits = view_digits(v);
    view_format_length(v, length, VIEW_UNIT_ANY, level);
    stp_ui_row("distance", level);
    snprintf(text, sizeof text, "%.*f  %.*f  %.*f", digits, d.x, digits, d.y, digits, d.z);
    stp_ui_row("by axis", text);
    view_format_length(v, sqrt(fmax(0.0, length * length - rise * rise)), VIEW_UNIT_LEVEL, level);
    view_format_length(v, rise, VIEW_UNIT_HEIGHT, high);
    snprintf(text, sizeof text, "%s level, %s up", level, high);
    stp_ui_row("", text);
}

/* Shows what was clicked last. */
static void clicked_rows(const viewer *v)
{
    const stp_pick *pick = &v->clicked;
    char text[160];
    view_format_position(v, pick->position, text);
    stp_ui_row("clicked", text);
    if (pick->interpolated)
        snprintf(text, sizeof text, "interpolated, from level %d of the pyramid",
                 pick->pyramid_level);
    else
        snprintf(text, sizeof text, "measured");
    stp_ui_row("", text);
    snprintf(text, sizeof text, "%.*f", view_digits(v) + 1, pick->radius);
    view_add_unit(v, VIEW_UNIT_ANY, text, sizeof text);
    stp_ui_row("disc's radius", text);
    if (pick->chunk != STP_PICK_NO_CHUNK) {
        snprintf(text, sizeof text, "%u, level %d", pick->chunk, pick->level);
        stp_ui_row("chunk", text);
    }
    if (v->scene.attributes & STP_HAS_INTENSITY && !v->options->attribute) {
        view_format_intensity(v->scene.intensity_top, pick->intensity, text);
        stp_ui_row("intensity", text);
    }
    if (v->scene.attributes & STP_HAS_CLASS) {
        snprintf(text, sizeof text, "%u", pick->class_id);
        stp_ui_row("class", text);
    }
    const view_grid_sample *grid = &v->values.grid;
    if (grid->known) {
        snprintf(text, sizeof text, "column %u, row %u", grid->column, grid->row);
        stp_ui_row("nearest sample", text);
        snprintf(text, sizeof text, "%.*f", view_digits(v) + 1, grid->height);
        view_add_unit(v, VIEW_UNIT_HEIGHT, text, sizeof text);
        stp_ui_row(grid->is_depth ? "its depth" : "its height", text);
        snprintf(text, sizeof text, "%u of %u missing", grid->missing, grid->told);
        stp_ui_row("neighbours", text);
    }
    for (uint32_t i = 0; i < v->values.count; i++) {
        snprintf(text, sizeof text, "%.15g", v->values.values[i]);
        stp_ui_row(v->values.names[i], text);
    }
}

/* Lists the finished lines, each with its length. */
static void measured_rows(viewer *v)
{
    view_measure *m = &v->measure;
    int removed = -1;
    char label[24], length[96];
    for (int i = 0; i < m->line_count; i++) {
        stp_ui_push_id(i);
        removed = stp_ui_button("x") ? i : removed;
        stp_ui_hint("removes it");
        stp_ui_same_line();
        snprintf(label, sizeof label, "line %d", i + 1);
        view_format_length(v, view_measure_length(m->lines[i]), VIEW_UNIT_ANY, length);
        stp_ui_row(label, length);
        stp_ui_pop_id();
    }
    if (removed >= 0)
        view_measure_remove(m, removed);
    if (m->line_count == 0)
        return;
    if (stp_ui_button("copy"))
        copy_measure(v);
    stp_ui_hint("both ends of each line");
    stp_ui_same_line();
    if (stp_ui_button("remove all"))
        *m = (view_measure){0};
}

void view_panel_measure(viewer *v)
{
    const stp_dvec3 *last = view_measure_last(&v->measure);
    char text[160];
    stp_ui_check("clicks measure", &v->control.measuring);
    if (last != NULL || v->measure.begun) {
        view_format_position(v, last != NULL ? last[0] : v->measure.first, text);
        stp_ui_row("first", text);
    }
    if (last != NULL) {
        view_format_position(v, last[1], text);
        stp_ui_row("second", text);
        distance_rows(v, last);
    }
    measured_rows(v);
    if (v->clicked.hit)
        clicked_rows(v);
    else
        stp_ui_note("Click the model to see what is there.");
}

static void kept_row(viewer *v, size_t i)
{
    view_bookmark *kept = &v->bookmarks.items[i];
    stp_ui_push_id((int)i);
    if (stp_ui_button("go"))
        view_recall(v, i);
    stp_ui_same_line();
    if (stp_ui_button("x")) {
        view_bookmarks_remove(&v->bookmarks, i);
        view_save_bookmarks(v);
    }
    stp_ui_hint("removes it");
    stp_ui_same_line();
    if (stp_ui_field("##name", kept->name, sizeof kept->name))
        view_save_bookmarks(v);
    stp_ui_pop_id();
}

void view_panel_kept(viewer *v)
{
    for (size_t i = 0; i < v->bookmarks.count; i++)
        kept_row(v, i);
    if (stp_ui_button("keep this view"))
        view_keep(v);
    stp_ui_same_line();
    if (stp_ui_button(v->record.on ? "end the path" : "record a path"))
        view_toggle_record(v);
    if (v->bookmarks.path[0] != '\0')
        stp_ui_note(v->bookmarks.path);
}

void view_panel_shot(viewer *v)
{
    stp_ui_choice("size", &v->shot_size, VIEW_SHOT_SIZES, ALL);
    stp_ui_hint("of the picture's longer side");
    if (v->shot.state == VIEW_SHOT_WRITING)
        stp_ui_note("The last one is being written.");
    else if (stp_ui_button("take it"))
        view_begin_shot(v);
}
