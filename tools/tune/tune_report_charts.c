/* The charts of a report. */
#include "tools/tune/tune_report.h"

#include <stdlib.h>

enum {
    OF_THRESHOLD,
    OF_POINTS,
    OF_PSNR,
    OF_MS,
    OF_PREDICTED,
    OF_MEASURED,
    OF_EXTRA,
    OF_FLICKER,
    COLUMNS
};

/* Figures of a setting by threshold, as columns. */
static double *columns_of(const tune_sweep *sweep, size_t setting)
{
    size_t count = sweep->params->threshold_count;
    double *columns = calloc(COLUMNS * count, sizeof *columns);
    for (size_t t = 0; columns != NULL && t < count; t++) {
        tune_summary s = tune_summarise(sweep, setting, t);
        const double values[COLUMNS] = {s.threshold_px, s.points,      s.psnr_db, s.ms,
                                        s.predicted_px, s.measured_px, s.extra,   s.flicker};
        for (size_t c = 0; c < COLUMNS; c++)
            columns[c * count + t] = values[c];
    }
    return columns;
}

static const char *series_name(const tune_report *r, size_t setting)
{
    return r->sweep->params->setting_count > 1 ? r->sweep->params->settings[setting].name : "PSNR";
}

static stp_status quality_chart(const tune_report *r, chart_text *out, stp_error *err)
{
    stp_status status = STP_OK;
    const tune_sweep_params *p = r->sweep->params;
    double *columns[CHART_SERIES_LIMIT] = {NULL};
    chart_series series[CHART_SERIES_LIMIT];
    size_t n = p->threshold_count;
    size_t settings = p->setting_count < CHART_SERIES_LIMIT ? p->setting_count : CHART_SERIES_LIMIT;
    for (size_t k = 0; k < settings; k++) {
        columns[k] = columns_of(r->sweep, k);
        if (columns[k] == NULL) {
            status = stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for a chart");
            goto done;
        }
        series[k] = (chart_series){.name = series_name(r, k),
                                   .x = columns[k] + OF_POINTS * n,
                                   .y = columns[k] + OF_PSNR * n,
                                   .count = n,
                                   .labels = k == 0 ? columns[k] : NULL};
    }
    chart_write(&(chart_axes){.title = "Quality against points drawn, by threshold",
                              .x_name = "points drawn, mean of the views",
                              .y_name = "PSNR in dB, all views together",
                              .x_log = true,
                              .series = series,
                              .count = settings},
                out);
done:
    for (size_t k = 0; k < settings; k++)
        free(columns[k]);
    return status;
}

stp_status tune_report_chart(const tune_report *r, int which, chart_text *out, stp_error *err)
{
    if (which == TUNE_CHART_QUALITY)
        return quality_chart(r, out, err);
    size_t n = r->sweep->params->threshold_count;
    double *c = columns_of(r->sweep, 0);
    if (c == NULL)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for a chart");
    const chart_series times[] = {{"median of the views", c, c + OF_MS * n, n, NULL, false, NULL}};
    const chart_series promise[] = {{"threshold", c, c, n, NULL, true, NULL},
                                    {"predicted", c, c + OF_PREDICTED * n, n, NULL, false, NULL},
                                    {"measured", c, c + OF_MEASURED * n, n, NULL, false, NULL}};
    const chart_series popping[] = {
        {"change beyond that of every sample", c, c + OF_EXTRA * n, n, NULL, false, NULL}};
    const chart_axes charts[TUNE_CHARTS] = {
        [TUNE_CHART_TIMES] = {"Time against the threshold", "threshold in pixels",
                              "milliseconds a frame", true, false, times, 1},
        [TUNE_CHART_PROMISE] = {"The error promise: greatest of all views", "threshold in pixels",
                                "pixels", true, true, promise, 3},
        [TUNE_CHART_POPPING] = {"Popping along short dollies", "threshold in pixels",
                                "RGB levels a frame (RMS)", true, false, popping, 1},
    };
    chart_write(&charts[which], out);
    free(c);
    return STP_OK;
}
