/* Writes a sweep as a folder: tune.csv, tune.json, charts, and index.html. index.html contains all
 * of it and its pictures and loads nothing from the network. Threads: the main thread only. */
#ifndef STP_TOOLS_TUNE_TUNE_REPORT_H
#define STP_TOOLS_TUNE_TUNE_REPORT_H

#include "tools/chart/chart.h"
#include "tools/tune/tune_folder.h"
#include "tools/tune/tune_table.h"

typedef struct tune_report {
    const tune_sweep *sweep;
    const tune_answer *answer;
    const char *model_path, *gl_renderer;
} tune_report;

enum { TUNE_CHART_QUALITY, TUNE_CHART_TIMES, TUNE_CHART_PROMISE, TUNE_CHART_POPPING, TUNE_CHARTS };

/* Writes one of the charts: of the first setting; the quality chart has all settings. Errors:
 * OUT_OF_MEMORY. */
stp_status tune_report_chart(const tune_report *report, int which, chart_text *out, stp_error *err);
/* Writes the page. folder: holds pictures while they are encoded. Errors: OUT_OF_MEMORY, IO. */
stp_status tune_report_page(const tune_report *report, tune_folder *folder, chart_text *out,
                            stp_error *err);
/* Writes all files into a folder that is not committed yet. Errors: OUT_OF_MEMORY, IO. */
stp_status tune_report_write(const tune_report *report, tune_folder *folder, stp_error *err);

#endif
