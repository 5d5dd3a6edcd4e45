/* Writes a profile as CSV or as an SVG chart. */
#include "tools/profile/profile_write.h"

#include "base/memory.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#define LINE_BYTES 256
/* The chart, in pixels: the plot and the margins around it. */
#define PLOT_WIDTH 1000.0
#define PLOT_HEIGHT 400.0
#define LEFT 90.0
#define TOP 20.0
#define WIDTH 1120.0
#define HEIGHT 480.0
/* Dots are told apart by cells of this size. */
#define DOT 1.0
#define TICKS 8.0
/* Decimals that doubles of these sizes carry. */
#define NUMBER "%.10g"

__attribute__((format(printf, 3, 4))) static stp_status put(stp_output *output, stp_error *err,
                                                            const char *format, ...)
{
    char line[LINE_BYTES];
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    return stp_output_write(output, line, (size_t)length, err);
}

stp_status profile_write_csv(const profile *p, stp_output *output, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(put(output, err, "distance,x,y,z,r,g,b\n"));
    for (size_t i = 0; i < p->count; i++) {
        const profile_point *q = &p->points[i];
        STP_TRY(put(output, err, NUMBER "," NUMBER "," NUMBER "," NUMBER ",%u,%u,%u\n", q->distance,
                    q->position.x, q->position.y, q->position.z, q->rgb[0], q->rgb[1], q->rgb[2]));
    }
done:
    return status;
}

/* ---- the chart ---- */

/* What an axis shows: numbers from low to high, a tick at each multiple of step. */
typedef struct axis {
    double low, high, step;
} axis;

/* A step of 1, 2 or 5 times a power of ten that gives about TICKS ticks. */
static double round_step(double range)
{
    const double raw = range / TICKS, tens = pow(10.0, floor(log10(raw)));
    return tens * (raw < 2.0 * tens ? 2.0 : raw < 5.0 * tens ? 5.0 : 10.0);
}

static axis axis_of(double low, double high)
{
    const double range = high > low ? high - low : fmax(1.0, 1e-6 * fabs(low));
    const double middle = 0.5 * (low + high);
    return (axis){middle - 0.5 * range, middle + 0.5 * range, round_step(range)};
}

static double on_axis(const axis *a, double value)
{
    return (value - a->low) / (a->high - a->low);
}

typedef struct chart {
    const profile *p;
    axis distance, height;
    stp_output *output;
} chart;

static stp_status put_ticks(const chart *c, stp_error *err)
{
    stp_status status = STP_OK;
    const axis *d = &c->distance, *h = &c->height;
    for (double k = ceil(d->low / d->step - 1e-9) + 0.0; k * d->step <= d->high * (1.0 + 1e-9);
         k += 1.0) {
        const double x = LEFT + PLOT_WIDTH * on_axis(d, k * d->step);
        STP_TRY(put(c->output, err, "<path d=\"M%.2f %.2fv-%.2f\"/>", x, TOP + PLOT_HEIGHT,
                    PLOT_HEIGHT));
        STP_TRY(put(c->output, err,
                    "<text x=\"%.2f\" y=\"%.2f\" text-anchor=\"middle\">%.9g</text>\n", x,
                    TOP + PLOT_HEIGHT + 18.0, k * d->step));
    }
    for (double k = ceil(h->low / h->step - 1e-9) + 0.0; k <= h->high / h->step + 1e-9; k += 1.0) {
        const double y = TOP + PLOT_HEIGHT * (1.0 - on_axis(h, k * h->step));
        STP_TRY(put(c->output, err, "<path d=\"M%.2f %.2fh%.2f\"/>", LEFT, y, PLOT_WIDTH));
        STP_TRY(put(c->output, err, "<text x=\"%.2f\" y=\"%.2f\" text-anchor=\"end\">%.9g</text>\n",
                    LEFT - 6.0, y + 4.0, k * h->step));
    }
done:
    return status;
}

static stp_status put_dots(const chart *c, stp_error *err)
{
    static const uint8_t ink[3] = {30, 90, 160}; /* of points without colours */
    stp_status status = STP_OK;
    const size_t columns = (size_t)(PLOT_WIDTH / DOT) + 1, rows = (size_t)(PLOT_HEIGHT / DOT) + 1;
    bool *drawn = NULL;
    STP_TRY(stp_alloc(&drawn, columns * rows, sizeof *drawn, "a chart", err));
    for (size_t i = 0; i < c->p->count; i++) {
        const profile_point *q = &c->p->points[i];
        const uint8_t *rgb = c->p->coloured ? q->rgb : ink;
        const double x = PLOT_WIDTH * on_axis(&c->distance, q->distance);
        const double y = PLOT_HEIGHT * (1.0 - on_axis(&c->height, q->position.z));
        bool *cell = &drawn[(size_t)(y / DOT) * columns + (size_t)(x / DOT)];
        if (!*cell)
            STP_TRY(put(c->output, err,
                        "<circle cx=\"%.2f\" cy=\"%.2f\" r=\"1.2\" fill=\"#%02x%02x%02x\"/>\n",
                        LEFT + x, TOP + y, rgb[0], rgb[1], rgb[2]));
        *cell = true;
    }
done:
    free(drawn);
    return status;
}

stp_status profile_write_svg(const profile *p, stp_output *output, stp_error *err)
{
    stp_status status = STP_OK;
    double low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < p->count; i++) {
        low = fmin(low, p->points[i].position.z);
        high = fmax(high, p->points[i].position.z);
    }
    const chart c = {p, {0.0, p->length, round_step(p->length)}, axis_of(low, high), output};
    STP_TRY(put(output, err,
                "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %g %g\" "
                "font-family=\"sans-serif\" font-size=\"12\">\n",
                WIDTH, HEIGHT));
    STP_TRY(put(output, err, "<rect width=\"%g\" height=\"%g\" fill=\"#fff\"/>\n", WIDTH, HEIGHT));
    STP_TRY(put(output, err, "<g stroke=\"#ddd\" fill=\"#333\" stroke-width=\"1\">\n"));
    STP_TRY(put(output, err, "<style>text{stroke:none}</style>\n"));
    STP_TRY(put_ticks(&c, err));
    STP_TRY(put(output, err, "</g>\n"));
    STP_TRY(put_dots(&c, err));
    STP_TRY(put(output, err,
                "<text x=\"%g\" y=\"%g\" text-anchor=\"middle\">distance</text>\n"
                "<text x=\"%g\" y=\"%g\">height</text>\n</svg>\n",
                LEFT + 0.5 * PLOT_WIDTH, HEIGHT - 12.0, 8.0, TOP + 0.5 * PLOT_HEIGHT));
done:
    return status;
}
