/* Makes profiles of measured lines, and shows and saves them. */
#include "tools/view/panels/view_profile_show.h"

#include "tools/view/panels/view_panels.h"
#include "tools/view/view_say.h"

#include <stdio.h>

#define WHITE 0xffffffffu
#define GROUND 0x101216d8u
/* Unscaled pixels. */
#define CHART_WIDTH_PX 600.0
#define CHART_HEIGHT_PX 150.0
#define MARGIN_PX 12.0

void view_profile_last(viewer *v)
{
    const view_measure *m = &v->measure;
    const stp_dvec3 *ends = m->line_count > 0 ? m->lines[m->line_count - 1] : NULL;
    stp_chunk_file *files[VIEW_MODELS_LIMIT];
    size_t count = 0;
    stp_error err = {0};
    for (size_t i = 0; i < v->scene.count; i++)
        if (!v->scene.models[i].hidden)
            files[count++] = v->scene.models[i].model->file;
    if (ends == NULL) {
        view_note(v, "measure a line first: M and two clicks");
        return;
    }
    const profile_line line = {
        .from = {ends[0].x, ends[0].y}, .to = {ends[1].x, ends[1].y}, .where = v->options->where};
    if (!(hypot(line.to[0] - line.from[0], line.to[1] - line.from[1]) > 0.0)) {
        view_note(v, "the line is upright: it has no length on the map");
        return;
    }
    if (view_profile_begin(&v->profile, files, count, &line, &err) == STP_OK)
        view_note(v, "the profile is being made");
    else
        view_note(v, "%s", err.message);
}

void view_profile_turn(viewer *v)
{
    stp_error err = {0};
    stp_status status = STP_OK;
    const bool saved = v->profile.state == VIEW_PROFILE_SAVING;
    if (!view_profile_poll(&v->profile, &status, &err))
        return;
    if (status != STP_OK)
        view_note(v, "%s", err.message);
    else if (saved)
        view_note(v, "the profile is in %s", v->profile.path);
    else
        view_note(v, "the profile has %zu points", v->profile.found.count);
}

static void save(viewer *v, const char *ending)
{
    char path[VIEW_PATH_BYTES];
    stp_error err = {0};
    stp_status status = view_files_free(path, v->scene.models[0].name, ending, &err);
    if (status == STP_OK)
        status = view_profile_save(&v->profile, path, ending[1] == 's', &err);
    if (status != STP_OK)
        view_note(v, "%s", err.message);
}

static bool is_shown(const view_profile *p)
{
    return p->state == VIEW_PROFILE_READY || p->state == VIEW_PROFILE_SAVING;
}

bool view_profile_close(viewer *v)
{
    if (!is_shown(&v->profile))
        return false;
    if (v->profile.state == VIEW_PROFILE_SAVING)
        view_note(v, "the profile is being written");
    else
        view_profile_forget(&v->profile, NULL);
    return true;
}

void view_panel_profile(viewer *v)
{
    const view_profile *p = &v->profile;
    char text[96];
    if (p->state == VIEW_PROFILE_FINDING || p->state == VIEW_PROFILE_SAVING) {
        stp_ui_note(p->state == VIEW_PROFILE_SAVING ? "It is being written." : "It is being made.");
        return;
    }
    if (stp_ui_button("of the last measured line"))
        view_profile_last(v);
    if (p->state != VIEW_PROFILE_READY) {
        stp_ui_note("M and two clicks measure a line; T shows the heights along it.");
        return;
    }
    snprintf(text, sizeof text, "%zu", p->found.count);
    stp_ui_row("points", text);
    view_format_length(v, p->found.width, VIEW_UNIT_LEVEL, text);
    stp_ui_row("strip's width", text);
    if (stp_ui_button("save CSV"))
        save(v, ".csv");
    stp_ui_same_line();
    if (stp_ui_button("save SVG"))
        save(v, ".svg");
    stp_ui_same_line();
    if (stp_ui_button("close"))
        view_profile_close(v);
}

/* The heights at the left, the lengths below. */
static void draw_labels(const viewer *v, double x, double y, double width, double height)
{
    const view_profile *p = &v->profile;
    const double line = stp_ui_text_height();
    char text[96], words[112];
    view_format_length(v, p->high, VIEW_UNIT_HEIGHT, text);
    stp_ui_draw_label(x, y, text, WHITE, false);
    view_format_length(v, p->low, VIEW_UNIT_HEIGHT, text);
    stp_ui_draw_label(x, y + height - 1.6 * line, text, WHITE, false);
    view_format_length(v, p->found.length, VIEW_UNIT_LEVEL, text);
    snprintf(words, sizeof words, "%s long", text);
    stp_ui_draw_label(x + width - 12.0 * line, y, words, WHITE, false);
}

void view_profile_draw(const viewer *v)
{
    const view_profile *p = &v->profile;
    const double s = stp_ui_scale(v->ui), x = MARGIN_PX * s, line = stp_ui_text_height() + 8.0 * s;
    const double width = fmin(CHART_WIDTH_PX * s, v->layout.picture_width - 2.0 * x);
    const double height = fmin(CHART_HEIGHT_PX * s, 0.4 * v->layout.picture_height);
    const double y = v->layout.height - height - 2.4 * line - x;
    const double inner = height - 2.0 * line;
    const double across = width / VIEW_PROFILE_COLUMNS, up = inner / VIEW_PROFILE_ROWS;
    if (!is_shown(p) || width < 40.0 * s || inner < 10.0 * s)
        return;
    stp_ui_draw_line(x, y + 0.5 * height, x + width, y + 0.5 * height, GROUND, height);
    for (size_t i = 0; i < p->cell_count; i++) {
        const view_profile_cell *c = &p->cells[i];
        const double left = x + c->column * across;
        const double at = y + line + inner - (c->row + 0.5) * up;
        const uint32_t colour = (uint32_t)c->rgb[0] << 24 | (uint32_t)c->rgb[1] << 16 |
                                (uint32_t)c->rgb[2] << 8 | 0xffu;
        stp_ui_draw_line(left, at, left + fmax(across, 1.5 * s), at, colour, fmax(up, 1.5 * s));
    }
    draw_labels(v, x, y, width, height);
}
