/* What other files of the viewer say things with: notes, coordinates, places in the window. */
#include "tools/view/view_say.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

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

void view_add_unit(const viewer *v, view_unit of, char *text, size_t bytes)
{
    const char *unit = view_scene_unit(&v->scene, of);
    const size_t length = strlen(text);
    if (unit[0] != '\0')
        snprintf(text + length, bytes - length, " %s", unit);
}

void view_format_length(const viewer *v, double length, view_unit of, char out[96])
{
    snprintf(out, 96, "%.*f", view_digits(v), length);
    view_add_unit(v, of, out, 96);
}

void view_format_height(const viewer *v, double height, char out[96])
{
    snprintf(out, 96, "%.6g", height);
    view_add_unit(v, VIEW_UNIT_HEIGHT, out, 96);
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
