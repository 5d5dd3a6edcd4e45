/* Writes charts: axes with round numbers, lines, points, a legend. */
#include "tools/chart/chart.h"

#include "base/memory.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 560, HEIGHT = 340, LEFT = 62, RIGHT = 16, TOP = 58, BOTTOM = 46 };

/* Side of the cells by which dots are told apart, pixels. */
#define DOT 0.5

/* Colours that most people can tell apart (Okabe and Ito). */
static const char *const colours[CHART_SERIES_LIMIT] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                        "#e69f00", "#56b4e9", "#666666", "#b0a000"};

void chart_text_add(chart_text *text, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    if (text->failed || length < 0 ||
        stp_grow(&text->bytes, &text->capacity, text->length + (size_t)length + 1, 1, "a report",
                 NULL) != STP_OK) {
        text->failed = true;
        return;
    }
    va_start(arguments, format);
    vsnprintf(text->bytes + text->length, (size_t)length + 1, format, arguments);
    va_end(arguments);
    text->length += (size_t)length;
}

void chart_text_escape(chart_text *text, const char *plain)
{
    for (; *plain; plain++)
        switch (*plain) {
        case '<':
            chart_text_add(text, "&lt;");
            break;
        case '&':
            chart_text_add(text, "&amp;");
            break;
        case '"':
            chart_text_add(text, "&quot;");
            break;
        default: /* a character that XML does not allow becomes a question mark */
            chart_text_add(text, "%c", (unsigned char)*plain < ' ' ? '?' : *plain);
        }
}

stp_status chart_text_check(const chart_text *text, stp_error *err)
{
    return text->failed ? stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the report")
                        : STP_OK;
}

/* ---- axes ---- */

typedef struct axis {
    bool log;
    double low, high; /* range of the drawn values; logarithms if log */
    double from, to;  /* range in the picture */
} axis;

static double scaled(const axis *a, double value)
{
    return a->log ? log10(value) : value;
}

static double place(const axis *a, double value)
{
    return a->from + (scaled(a, value) - a->low) / (a->high - a->low) * (a->to - a->from);
}

static bool drawn(const axis *a, double value)
{
    return isfinite(value) && (!a->log || value > 0.0);
}

/* True if a point has a place on both axes. */
static bool shown(const chart_axes *chart, const chart_series *s, size_t i)
{
    const axis x = {.log = chart->x_log}, y = {.log = chart->y_log};
    return drawn(&x, s->x[i]) && drawn(&y, s->y[i]);
}

static axis axis_of(const chart_axes *chart, bool of_x)
{
    axis a = {.log = of_x ? chart->x_log : chart->y_log,
              .low = INFINITY,
              .high = -INFINITY,
              .from = of_x ? LEFT : HEIGHT - BOTTOM,
              .to = of_x ? WIDTH - RIGHT : TOP};
    for (size_t s = 0; s < chart->count; s++)
        for (size_t i = 0; i < chart->series[s].count; i++) {
            double value = of_x ? chart->series[s].x[i] : chart->series[s].y[i];
            if (!shown(chart, &chart->series[s], i))
                continue;
            a.low = fmin(a.low, scaled(&a, value));
            a.high = fmax(a.high, scaled(&a, value));
        }
    if (!(a.low <= a.high))
        a.low = a.high = 0.0;
    double margin = a.high > a.low ? 0.05 * (a.high - a.low) : 0.5;
    a.low -= margin;
    a.high += margin;
    return a;
}

/* The largest of 1, 2 and 5 times a power of ten that makes five marks or more. */
static double step_of(double length)
{
    double power = pow(10.0, floor(log10(length / 5.0)));
    double times = length / 5.0 / power;
    return power * (times >= 5.0 ? 5.0 : times >= 2.0 ? 2.0 : 1.0);
}

static void mark(const axis *a, bool of_x, double value, chart_text *out)
{
    double at = place(a, value);
    char text[32];
    if (fabs(value) >= 1e6)
        snprintf(text, sizeof text, "%g M", value / 1e6);
    else if (fabs(value) >= 1e4)
        snprintf(text, sizeof text, "%g k", value / 1e3);
    else /* avoids "-0" */
        snprintf(text, sizeof text, "%g", value == 0.0 ? 0.0 : value);
    if (of_x)
        chart_text_add(out,
                       "<path d=\"M%.1f %d V%d\" stroke=\"currentColor\" stroke-opacity=\".15\"/>"
                       "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%s</text>\n",
                       at, TOP, HEIGHT - BOTTOM, at, HEIGHT - BOTTOM + 16, text);
    else
        chart_text_add(out,
                       "<path d=\"M%d %.1f H%d\" stroke=\"currentColor\" stroke-opacity=\".15\"/>"
                       "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%s</text>\n",
                       LEFT, at, WIDTH - RIGHT, LEFT - 6, at + 4.0, text);
}

static void mark_axis(const axis *a, bool of_x, chart_text *out)
{
    if (!a->log) {
        double step = step_of(a->high - a->low);
        for (double v = ceil(a->low / step); v * step <= a->high; v++)
            mark(a, of_x, v * step, out);
        return;
    }
    static const double digits[3] = {1.0, 2.0, 5.0};
    double decades = a->high - a->low;
    int last = decades < 2.2 ? 3 : 1;
    for (double p = floor(a->low); p <= a->high; p++)
        for (int i = 0; i < last; i++) {
            double value = digits[i] * pow(10.0, p);
            if (log10(value) >= a->low && log10(value) <= a->high)
                mark(a, of_x, value, out);
        }
}

/* ---- lines ---- */

static void draw_series(const chart_series *s, const axis *x, const axis *y, const char *colour,
                        chart_text *out)
{
    bool begun = false;
    double label_x = INFINITY, label_y = INFINITY; /* place of the last label */
    chart_text_add(out, "<path fill=\"none\" stroke=\"%s\" stroke-width=\"2\"%s d=\"", colour,
                   s->dashed ? " stroke-dasharray=\"5 4\"" : "");
    for (size_t i = 0; i < s->count; i++) {
        if (!drawn(x, s->x[i]) || !drawn(y, s->y[i]))
            continue;
        chart_text_add(out, "%s%.1f %.1f", begun ? " L" : "M", place(x, s->x[i]),
                       place(y, s->y[i]));
        begun = true;
    }
    chart_text_add(out, "%s\"/>\n", begun ? "" : "M0 0");
    for (size_t i = 0; i < s->count; i++) {
        if (!drawn(x, s->x[i]) || !drawn(y, s->y[i]))
            continue;
        double px = place(x, s->x[i]), py = place(y, s->y[i]);
        if (!s->dashed)
            chart_text_add(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3\" fill=\"%s\"/>", px, py,
                           colour);
        if (s->labels == NULL || (fabs(px - label_x) < 40.0 && fabs(py - label_y) < 12.0))
            continue; /* would overlap another label */
        label_x = px;
        label_y = py;
        chart_text_add(out, "<text x=\"%.1f\" y=\"%.1f\" font-size=\"10\">%g px</text>", px + 5.0,
                       py + 12.0, s->labels[i]);
    }
}

/* Each cell of DOT pixels gets one dot. */
static void draw_dots(const chart_series *s, const axis *x, const axis *y, chart_text *out)
{
    const size_t columns = (size_t)(WIDTH / DOT) + 1, rows = (size_t)(HEIGHT / DOT) + 1;
    bool *taken = NULL;
    out->failed |= stp_alloc(&taken, columns * rows, sizeof *taken, "a chart", NULL) != STP_OK;
    for (size_t i = 0; i < s->count && !out->failed; i++) {
        if (!drawn(x, s->x[i]) || !drawn(y, s->y[i]))
            continue;
        const double px = place(x, s->x[i]), py = place(y, s->y[i]);
        bool *cell = &taken[(size_t)(py / DOT) * columns + (size_t)(px / DOT)];
        if (!*cell)
            chart_text_add(out,
                           "<circle cx=\"%.2f\" cy=\"%.2f\" r=\".7\" fill=\"#%02x%02x%02x\"/>\n",
                           px, py, s->dots[i][0], s->dots[i][1], s->dots[i][2]);
        *cell = true;
    }
    free(taken);
}

static void draw_legend(const chart_axes *chart, chart_text *out)
{
    int x = LEFT;
    for (size_t s = 0; s < chart->count; s++) {
        if (chart->series[s].name[0] == '\0')
            continue;
        chart_text_add(out,
                       "<path d=\"M%d 40 h18\" stroke=\"%s\" stroke-width=\"2\"%s/>"
                       "<text x=\"%d\" y=\"44\">",
                       x, colours[s % CHART_SERIES_LIMIT],
                       chart->series[s].dashed ? " stroke-dasharray=\"5 4\"" : "", x + 23);
        chart_text_escape(out, chart->series[s].name);
        chart_text_add(out, "</text>\n");
        x += 40 + 7 * (int)strlen(chart->series[s].name);
    }
}

void chart_write(const chart_axes *chart, chart_text *out)
{
    axis x = axis_of(chart, true), y = axis_of(chart, false);
    chart_text_add(out,
                   "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" "
                   "height=\"%d\" font-family=\"sans-serif\" font-size=\"12\" "
                   "fill=\"currentColor\" role=\"img\">\n<title>",
                   WIDTH, HEIGHT, WIDTH, HEIGHT);
    chart_text_escape(out, chart->title);
    chart_text_add(out, "</title>\n<text x=\"%d\" y=\"20\" font-size=\"15\" font-weight=\"600\">",
                   LEFT);
    chart_text_escape(out, chart->title);
    chart_text_add(out, "</text>\n");
    mark_axis(&x, true, out);
    mark_axis(&y, false, out);
    for (size_t s = 0; s < chart->count; s++)
        if (chart->series[s].dots)
            draw_dots(&chart->series[s], &x, &y, out);
        else
            draw_series(&chart->series[s], &x, &y, colours[s % CHART_SERIES_LIMIT], out);
    draw_legend(chart, out);
    chart_text_add(out, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">",
                   (LEFT + WIDTH - RIGHT) / 2, HEIGHT - 10);
    chart_text_escape(out, chart->x_name);
    chart_text_add(out,
                   "</text>\n<text transform=\"translate(14 %d) rotate(-90)\" "
                   "text-anchor=\"middle\">",
                   (TOP + HEIGHT - BOTTOM) / 2);
    chart_text_escape(out, chart->y_name);
    chart_text_add(out, "</text>\n</svg>\n");
}
