/* Writes line charts as SVG, and the growing text that reports are made of. Threads: any. */
#ifndef STP_TOOLS_TUNE_TUNE_CHART_H
#define STP_TOOLS_TUNE_TUNE_CHART_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>

/* A text that grows; zero is empty. If memory runs out, text is left out and failed is set. */
typedef struct tune_text {
    char *bytes; /* ends with 0 if not empty; free with free() */
    size_t length, capacity;
    bool failed;
} tune_text;

void tune_text_add(tune_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Appends text, escaped for XML. */
void tune_text_escape(tune_text *text, const char *plain);
/* Errors: OUT_OF_MEMORY. */
stp_status tune_text_check(const tune_text *text, stp_error *err);

typedef struct tune_series {
    const char *name;
    const double *x, *y;
    size_t count;
    const double *labels; /* a number for each point; may be NULL */
    bool dashed;
} tune_series;

#define TUNE_SERIES_LIMIT 8

typedef struct tune_chart {
    const char *title, *x_name, *y_name;
    bool x_log, y_log; /* logarithmic: values that are not above 0 are left out */
    const tune_series *series;
    size_t count;
} tune_chart;

/* Writes an <svg> element that is a complete file. */
void tune_chart_write(const tune_chart *chart, tune_text *out);

#endif
