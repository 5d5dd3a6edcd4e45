/* Writes a profile as CSV or as an SVG chart. */
#include "tools/profile/profile_write.h"

#include "base/memory.h"
#include "tools/chart/chart.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINE_BYTES 256
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

/* The points as a series of dots. */
typedef struct dots {
    double *x, *y;
    uint8_t (*rgb)[3];
} dots;

static stp_status fill_dots(dots *out, const profile *p, stp_error *err)
{
    static const uint8_t ink[3] = {30, 90, 160}; /* of points without colours */
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&out->x, p->count, sizeof *out->x, "a chart", err));
    STP_TRY(stp_alloc(&out->y, p->count, sizeof *out->y, "a chart", err));
    STP_TRY(stp_alloc(&out->rgb, p->count, sizeof *out->rgb, "a chart", err));
    for (size_t i = 0; i < p->count; i++) {
        out->x[i] = p->points[i].distance;
        out->y[i] = p->points[i].position.z;
        memcpy(out->rgb[i], p->coloured ? p->points[i].rgb : ink, sizeof ink);
    }
done:
    return status;
}

stp_status profile_write_svg(const profile *p, stp_output *output, stp_error *err)
{
    stp_status status = STP_OK;
    dots d = {0};
    chart_text text = {0};
    STP_TRY(fill_dots(&d, p, err));
    const chart_series points = {
        .name = "", .x = d.x, .y = d.y, .count = p->count, .dots = (const uint8_t(*)[3])d.rgb};
    const chart_axes chart = {.title = "Heights along the line",
                              .x_name = "distance",
                              .y_name = "height",
                              .series = &points,
                              .count = 1};
    chart_write(&chart, &text);
    STP_TRY(chart_text_check(&text, err));
    STP_TRY(stp_output_write(output, text.bytes, text.length, err));
done:
    free(d.x);
    free(d.y);
    free(d.rgb);
    free(text.bytes);
    return status;
}
