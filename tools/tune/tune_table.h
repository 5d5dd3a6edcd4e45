/* A sweep as figures: one line per threshold, CSV with one row per view and threshold, and JSON.
 * Threads: the main thread only. */
#ifndef STP_TOOLS_TUNE_TUNE_TABLE_H
#define STP_TOOLS_TUNE_TUNE_TABLE_H

#include "base/file.h"
#include "tools/tune/tune_solve.h"
#include "tools/tune/tune_sweep.h"

#include <stdio.h>

/* One setting at one threshold, over all views. */
typedef struct tune_summary {
    double threshold_px;
    /* From the squared differences of all views' covered pixels together. */
    double psnr_db;
    double ssim, angle_mean_deg, angle_median_deg,
        angle_p95_deg;                                /* means weighted by covered pixels */
    double shift_mean_px, shift_p95_px, shift_max_px; /* means by outline; the last: greatest */
    double holes, spill, points, patches;             /* means over the views */
    double file_bytes, gpu_bytes;                     /* greatest of the views */
    double ms;                                        /* median of the views */
    double predicted_px;                              /* greatest of the views */
    double measured_px; /* greatest of the views; NaN if no disc was measured */
    double view_ratio;  /* median of the views' greatest predicted / greatest measured, or NaN */
    tune_ratios ratios;
    double change, change_full, extra; /* RGB levels from frame to frame: of this picture, of every
                                          sample, and the difference of the two */
    double flicker;                    /* holes that open or close per frame */
    uint64_t discs;
} tune_summary;

/* What the first setting's thresholds speak for, in words; empty if fewer than two were measured.
 */
void tune_advice_of(const tune_sweep *sweep, char out[240]);

/* The goal and the threshold found for it. */
typedef struct tune_answer {
    tune_goal_kind kind; /* TUNE_GOAL_NONE: nothing */
    double target;
    tune_solution found;
} tune_answer;

tune_summary tune_summarise(const tune_sweep *sweep, size_t setting, size_t threshold);
/* Gets a setting's figures, threshold included, at a number of points. Interpolates between
 * thresholds, linearly in the logarithm of points. False if the setting never draws so many or so
 * few. */
bool tune_at_points(const tune_sweep *sweep, size_t setting, double points, tune_summary *out);

/* Pools rows of all views of a sweep to the figure that solvers solve for. */
double tune_pooled_psnr(const tune_row *rows, size_t count);
double tune_median_ms(const tune_row *rows, size_t count);
double tune_greatest_bytes(const tune_row *rows, size_t count);

/* A figure as text, "-" for NaN. */
typedef struct tune_figure {
    char text[32];
} tune_figure;
tune_figure tune_figure_write(double value, int decimals);
/* A whole number with its digits grouped: 12,345,678. Rounds; values from 0 to 1e18. */
tune_figure tune_figure_count(double value);
/* The value that a goal was given or reached; bytes are grouped. */
tune_figure tune_figure_goal(tune_goal_kind kind, double value);

/* What the columns of the tables mean. Those of the page alone come last. */
#define TUNE_LEGEND_PRINTED 12
#define TUNE_LEGEND_COUNT 16
typedef struct tune_term {
    const char *name, *meaning;
} tune_term;
extern const tune_term tune_legend[TUNE_LEGEND_COUNT];
/* Why every sample may score below a threshold. */
extern const char tune_legend_zero[];

/* Whether a row is of the threshold that drawing commands take if they are given none. */
bool tune_is_default(const tune_sweep *sweep, size_t setting, double threshold_px);

void tune_table_print(const tune_sweep *sweep, const tune_answer *answer, FILE *out);
/* Errors: IO. */
stp_status tune_csv_write(const tune_sweep *sweep, stp_output *out, stp_error *err);
/* NULL if memory is exhausted. path: the model's path. */
struct cJSON *tune_json(const tune_sweep *sweep, const tune_answer *answer, const char *path,
                        const char *gl_renderer);

#endif
