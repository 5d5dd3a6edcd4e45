/* Writes the files of a report, and its charts. */
#include "tools/tune/tune_report.h"

#include "base/json.h"
#include "base/memory.h"

#include <stdlib.h>

/* ---- charts ---- */

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

/* The figures of a setting by threshold, as columns. */
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

static stp_status quality_chart(const tune_report *r, tune_text *out, stp_error *err)
{
    stp_status status = STP_OK;
    const tune_sweep_params *p = r->sweep->params;
    double *columns[TUNE_SERIES_LIMIT] = {NULL};
    tune_series series[TUNE_SERIES_LIMIT];
    size_t n = p->threshold_count;
    size_t settings = p->setting_count < TUNE_SERIES_LIMIT ? p->setting_count : TUNE_SERIES_LIMIT;
    for (size_t k = 0; k < settings; k++) {
        columns[k] = columns_of(r->sweep, k);
        if (columns[k] == NULL) {
            status = stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for a chart");
            goto done;
        }
        series[k] = (tune_series){.name = series_name(r, k),
                                  .x = columns[k] + OF_POINTS * n,
                                  .y = columns[k] + OF_PSNR * n,
                                  .count = n,
                                  .labels = k == 0 ? columns[k] : NULL};
    }
    tune_chart_write(&(tune_chart){.title = "Quality against points drawn, by threshold",
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

stp_status tune_report_chart(const tune_report *r, int which, tune_text *out, stp_error *err)
{
    if (which == TUNE_CHART_QUALITY)
        return quality_chart(r, out, err);
    size_t n = r->sweep->params->threshold_count;
    double *c = columns_of(r->sweep, 0);
    if (c == NULL)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for a chart");
    const tune_series times[] = {{"median of the views", c, c + OF_MS * n, n, NULL, false}};
    const tune_series promise[] = {{"threshold", c, c, n, NULL, true},
                                   {"predicted", c, c + OF_PREDICTED * n, n, NULL, false},
                                   {"measured", c, c + OF_MEASURED * n, n, NULL, false}};
    const tune_series popping[] = {
        {"change beyond that of every sample", c, c + OF_EXTRA * n, n, NULL, false}};
    const tune_chart charts[TUNE_CHARTS] = {
        [TUNE_CHART_TIMES] = {"Time against the threshold", "threshold in pixels",
                              "milliseconds a frame", true, false, times, 1},
        [TUNE_CHART_PROMISE] = {"The error promise: greatest of all views", "threshold in pixels",
                                "pixels", true, true, promise, 3},
        [TUNE_CHART_POPPING] = {"Popping along short dollies", "threshold in pixels",
                                "RGB levels a frame (RMS)", true, false, popping, 1},
    };
    tune_chart_write(&charts[which], out);
    free(c);
    return STP_OK;
}

/* ---- files ---- */

static stp_status write_text(const tune_text *text, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *output = NULL;
    STP_TRY(tune_text_check(text, err));
    STP_TRY(stp_output_create(&output, path, false, err));
    STP_TRY(stp_output_write(output, text->bytes, text->length, err));
    STP_TRY(stp_output_commit(&output, err));
done:
    stp_output_destroy(&output);
    return status;
}

static stp_status write_csv(const tune_report *r, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *output = NULL;
    STP_TRY(stp_output_create(&output, path, false, err));
    STP_TRY(tune_csv_write(r->sweep, output, err));
    STP_TRY(stp_output_commit(&output, err));
done:
    stp_output_destroy(&output);
    return status;
}

stp_status tune_report_write(const tune_report *r, tune_folder *folder, stp_error *err)
{
    static const char *const names[TUNE_CHARTS] = {"quality.svg", "times.svg", "promise.svg",
                                                   "popping.svg"};
    stp_status status = STP_OK;
    tune_text text = {0};
    STP_TRY(write_csv(r, tune_folder_file(folder, "tune.csv"), err));
    STP_TRY(stp_json_save(tune_json(r->sweep, r->answer, r->model_path, r->gl_renderer),
                          tune_folder_file(folder, "tune.json"), false, err));
    for (int i = 0; i < TUNE_CHARTS; i++) {
        text.length = 0;
        STP_TRY(tune_report_chart(r, i, &text, err));
        STP_TRY(write_text(&text, tune_folder_file(folder, names[i]), err));
    }
    text.length = 0;
    STP_TRY(tune_report_page(r, folder, &text, err));
    STP_TRY(write_text(&text, tune_folder_file(folder, "index.html"), err));
done:
    free(text.bytes);
    return status;
}
