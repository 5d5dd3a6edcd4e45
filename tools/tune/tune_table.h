/* A sweep as figures: one line a threshold, one row a view and threshold, JSON.
 * Threads: the main thread only. */
#ifndef STP_TOOLS_TUNE_TUNE_TABLE_H
#define STP_TOOLS_TUNE_TUNE_TABLE_H

#include "base/file.h"
#include "tools/tune/tune_solve.h"
#include "tools/tune/tune_sweep.h"

#include <stdio.h>

/* A setting at a threshold over all views. */
typedef struct tune_summary {
    double threshold_px;
    /* Of the squared differences of all views' covered pixels together. */
    double psnr_db;
    double ssim, angle_mean_deg, angle_median_deg, angle_p95_deg; /* means by pixels covered */
    double shift_mean_px, shift_p95_px, shift_max_px;             /* means by outline; greatest */
    double holes, spill, points, patches;                         /* means of the views */
    double file_bytes, gpu_bytes;                                 /* greatest of the views */
    double ms;                                                    /* median of the views */
    double predicted_px;                                          /* greatest of the views */
    double measured_px; /* likewise; NaN where no disc was measured */
    double view_ratio;  /* median of the views' greatest predicted / greatest measured, or NaN */
    tune_ratios ratios;
    double change, change_full, extra; /* RGB levels from frame to frame: its own, that of every
                                          sample, and what differs between the two */
    double flicker;                    /* holes that open or close, a frame */
    uint64_t discs;
} tune_summary;

/* What was solved for. */
typedef struct tune_answer {
    tune_goal_kind kind; /* TUNE_GOAL_NONE: nothing */
    double target;
    tune_solution found;
} tune_answer;

tune_summary tune_summarise(const tune_sweep *sweep, size_t setting, size_t threshold);
/* A setting's figures where it draws so many points, between its thresholds (linear in the
 * logarithm of points); false where it never draws so many or so few. The threshold, too. */
bool tune_at_points(const tune_sweep *sweep, size_t setting, double points, tune_summary *out);

/* Of rows of the views of a sweep: what solvers solve for. */
double tune_pooled_psnr(const tune_row *rows, size_t count);
double tune_median_ms(const tune_row *rows, size_t count);
double tune_greatest_bytes(const tune_row *rows, size_t count);

/* A figure as text, "-" for NaN. */
typedef struct tune_figure {
    char text[24];
} tune_figure;
tune_figure tune_figure_write(double value, int decimals);

void tune_table_print(const tune_sweep *sweep, const tune_answer *answer, FILE *out);
/* Errors: IO. */
stp_status tune_csv_write(const tune_sweep *sweep, stp_output *out, stp_error *err);
/* NULL where memory is exhausted. path: the model's. */
struct cJSON *tune_json(const tune_sweep *sweep, const tune_answer *answer, const char *path,
                        const char *gl_renderer);

#endif
