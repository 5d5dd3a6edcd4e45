/* What other files of the viewer say things with: notes, coordinates, places in the window. */
#include "tools/view/view_app.h"

#include <stdarg.h>
#include <stdio.h>

#define NOTE_S 6.0

void view_note(viewer *v, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(v->note, sizeof v->note, format, arguments);
    va_end(arguments);
    v->note_until_s = v->now_s + NOTE_S;
    v->ui_turns = VIEW_TURNS_TO_SETTLE;
}

int view_digits(const viewer *v)
{
    double digits = 5.0 - floor(log10(v->scene.ball.radius));
    return (int)fmin(fmax(digits, 3.0), 12.0);
}

void view_format_position(const viewer *v, stp_dvec3 p, char out[160])
{
    int digits = view_digits(v);
    snprintf(out, 160, "%.*f  %.*f  %.*f", digits, p.x, digits, p.y, digits, p.z);
}

void view_format_length(double length, int digits, const char *unit, char out[96])
{
    snprintf(out, 96, "%.*f%s%s", digits, length, unit[0] != '\0' ? " " : "", unit);
}

void view_format_height(const viewer *v, double height, char out[96])
{
    const char *unit = view_scene_height_unit(&v->scene);
    snprintf(out, 96, "%.6g%s%s", height, unit[0] != '\0' ? " " : "", unit);
}

bool view_place_drawn(const viewer *v, stp_dvec3 p, double at[2])
{
    const stp_view *view = &v->control.view;
    stp_dvec3 w = stp_view_project(view, p);
    at[0] = w.x;
    at[1] = v->layout.height - w.y;
    return w.z > view->near_depth && isfinite(w.x) && isfinite(w.y);
}

bool view_place(const viewer *v, stp_dvec3 place, double at[2])
{
    return view_place_drawn(v, stp_exaggerated(&v->control.params, place), at);
}
