/* Writes charts of lines or of dots as SVG, and the growing text that reports are made of. Threads:
 * any. */
#ifndef STP_TOOLS_CHART_CHART_H
#define STP_TOOLS_CHART_CHART_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A text that grows; zero is empty. If memory runs out, text is left out and failed is set. */
typedef struct chart_text {
    char *bytes; /* ends with 0 if not empty; free with free() */
    size_t length, capacity;
    bool failed;
} chart_text;

void chart_text_add(chart_text *text, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* Appends text, escaped for XML. */
void chart_text_escape(chart_text *text, const char *plain);
/* Errors: OUT_OF_MEMORY. */
stp_status chart_text_check(const chart_text *text, stp_error *err);

typedef struct chart_series {
    const char *name; /* "": not in the legend */
    const double *x, *y;
    size_t count;
    const double *labels; /* a number for each point; may be NULL */
    bool dashed;
    /* The series is dots of these colours, without a line. If dots would cover each other, only the
     * first is drawn. NULL: a line. */
    const uint8_t (*dots)[3];
} chart_series;

#define CHART_SERIES_LIMIT 8

typedef struct chart_axes {
    const char *title, *x_name, *y_name;
    bool x_log, y_log; /* logarithmic: values that are not above 0 are left out */
    const chart_series *series;
    size_t count;
} chart_axes;

/* Writes an <svg> element that is a complete file. */
void chart_write(const chart_axes *chart, chart_text *out);

#endif
