/* Draws the colour bar: what elevation or intensity the colours of the palette stand for. */
#include "tools/view/panels/view_legend.h"

#include "runtime/colour_range.h"
#include "runtime/stream/shown.h"
#include "tools/view/view_say.h"

#include <stdio.h>

#define WHITE 0xffffffffu
#define STEPS 64
/* Unscaled pixels. */
#define BAR_WIDTH_PX 16.0
#define BAR_HEIGHT_PX 180.0

static uint32_t colour_at(stp_palette palette, double value)
{
    float rgb[3];
    uint32_t rgba = 0;
    stp_palette_colour(palette, value, rgb);
    for (int c = 0; c < 3; c++)
        rgba = rgba << 8 | (uint32_t)(255.0f * rgb[c] + 0.5f);
    return rgba << 8 | 0xffu;
}

/* Whether intensities are whole numbers in the scans. */
static bool are_whole(double top)
{
    return top >= 255.0 || fabs(top - nearbyint(top)) < 1e-6;
}

/* Writes an intensity in the scans' own numbers, or in per cent. */
static void intensity_words(double top, double intensity, char out[40])
{
    if (top > 0.0)
        snprintf(out, 40, are_whole(top) ? "%.0f" : "%.3g", intensity * top);
    else
        snprintf(out, 40, "%.0f %%", 100.0 * intensity);
}

void view_format_intensity(double top, double intensity, char out[64])
{
    const double step = top / 255.0; /* samples have 8 bits */
    char words[40];
    intensity_words(top, intensity, words);
    if (are_whole(top) && step > 1.0)
        snprintf(out, 64, "about %s, in steps of %.0f", words, ceil(step));
    else
        snprintf(out, 64, "%s%s", words, top > 0.0 ? "" : " of the greatest");
}

/* Writes a value of the palette's range. */
static void value_words(const viewer *v, double value, char out[96])
{
    const struct stp_shown *shown = v->scene.models[0].model->shown;
    double range[2];
    if (shown && v->control.params.colour == STP_COLOUR_INTENSITY) {
        stp_shown_name(shown, range);
        snprintf(out, 64, "%.6g", range[0] + value * (range[1] - range[0]));
    } else if (v->control.params.colour == STP_COLOUR_ELEVATION)
        view_format_height(v, value, out);
    else
        intensity_words(v->scene.intensity_top, value, out);
}

/* Whether the picture shows colours of the palette. */
static bool is_graded(const stp_draw_params *p)
{
    return (p->colour == STP_COLOUR_ELEVATION || p->colour == STP_COLOUR_INTENSITY) &&
           p->colour_range[0] < p->colour_range[1] &&
           (p->shade <= STP_SHADE_UNLIT || (p->shade >= STP_SHADE_LEVEL && p->overlay > 0.0));
}

static const char *title(const viewer *v)
{
    const struct stp_shown *shown = v->scene.models[0].model->shown;
    double range[2];
    if (v->control.params.colour == STP_COLOUR_ELEVATION)
        return "elevation";
    return shown ? stp_shown_name(shown, range) : "intensity";
}

void view_legend_draw(const viewer *v, double left)
{
    const stp_draw_params *p = &v->control.params;
    const double s = stp_ui_scale(v->ui), line = 1.6 * stp_ui_text_height();
    const double height = fmin(BAR_HEIGHT_PX * s, 0.5 * v->layout.picture_height);
    const double x = left + 12.0 * s, width = BAR_WIDTH_PX * s, step = height / STEPS;
    const double low = v->layout.height - 0.5 * (v->layout.picture_height - height);
    char text[96];
    if (!is_graded(p))
        return;
    stp_ui_draw_label(x, low - height - 1.6 * line, title(v), WHITE, false);
    for (int i = 0; i < STEPS; i++) {
        const double y = low - (i + 0.5) * step;
        stp_ui_draw_line(x, y, x + width, y, colour_at(stp_colour_palette(p), (i + 0.5) / STEPS),
                         step + 1.0);
    }
    for (int i = 0; i <= 2; i++) {
        const double part = 0.5 * i;
        value_words(v, p->colour_range[0] + part * (p->colour_range[1] - p->colour_range[0]), text);
        stp_ui_draw_label(x + width, low - part * height - 0.4 * line, text, WHITE, false);
    }
}
