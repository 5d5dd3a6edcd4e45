/* Measures what thresholds cost and buy: named settings of the renderer times thresholds, over
 * views, against a reference.
 *
 * The reference of a view is every sample (--lod full), drawn with several times as many pixels and
 * averaged, because a plain picture of every sample has steps along its outlines. Normals, and
 * changes along a dolly, are compared with the plain picture of every sample. References are drawn
 * once and kept, 4 bytes per pixel and view. Threads: the render thread. */
#ifndef STP_TOOLS_TUNE_TUNE_SWEEP_H
#define STP_TOOLS_TUNE_TUNE_SWEEP_H

#include "base/pool.h"
#include "base/progress.h"
#include "tools/compare/compare_metrics.h"
#include "tools/draw/draw_save.h"
#include "tools/tune/tune_discs.h"
#include "tools/tune/tune_metrics.h"
#include "tools/tune/tune_views.h"

/* A way to draw, compared with others at equal numbers of points. */
typedef struct tune_setting {
    const char *name;
    stp_draw_params params; /* without the threshold */
} tune_setting;

/* One view at one threshold. */
typedef struct tune_row {
    compare_metrics compared;
    tune_shift shift;
    tune_angles angles;
    tune_cut cut;
    double ms; /* median of the repeats */
    double
        predicted_px; /* greatest of the measured discs; cut.max_error_px is of all drawn samples */
    double measured_px; /* greatest of the measured discs */
    uint64_t discs;     /* number of measured discs */
    uint32_t passes;
} tune_row;

/* A disc that is no farther off lies on the surface: predicted / measured is not computed for it.
 */
#define TUNE_ON_SURFACE_PX 1e-6

/* Ratios of predicted to measured error, over the random discs of all views that do not lie on the
 * surface. NaN if there are none. */
typedef struct tune_ratios {
    size_t discs, broken;             /* broken: those measured above the threshold, of all discs */
    double median, p10, p90;          /* predicted / measured */
    double factor[TUNE_FACTOR_COUNT]; /* medians */
} tune_ratios;

/* One setting at one threshold. */
typedef struct tune_point {
    double threshold_px;
    tune_row *rows; /* per view */
    tune_change change[TUNE_DOLLIES];
    tune_ratios ratios;
} tune_point;

/* A picture that the page shows: top row first, straight alpha. */
typedef struct tune_shot {
    size_t view, picture; /* setting * thresholds + threshold; TUNE_REFERENCE */
    stp_image image;
} tune_shot;
#define TUNE_REFERENCE SIZE_MAX
#define TUNE_SHOTS_LIMIT 24
#define TUNE_SHOT_VIEWS 3

typedef struct tune_sweep_params {
    const stp_model *model;
    stp_renderer *renderer;
    const tune_views *views;
    int aa;    /* index in DRAW_AA, of the judged pictures */
    int times; /* pixels of the reference along each side of a pixel */
    const tune_setting *settings;
    size_t setting_count;
    const double *thresholds; /* rising */
    size_t threshold_count;
    uint64_t repeat;     /* timed pictures per view and threshold */
    size_t discs;        /* random discs per picture */
    const size_t *shown; /* thresholds whose pictures are kept */
    size_t shown_count;
    const stp_progress *progress;
    stp_pool *pool;
} tune_sweep_params;

typedef struct tune_sweep {
    const tune_sweep_params *params;
    tune_point *points;   /* setting by setting, each by threshold */
    uint8_t **references; /* per view, bottom row first, straight alpha */
    tune_discs discs;
    tune_shot shots[TUNE_SHOTS_LIMIT];
    size_t shot_count;
    draw_picture picture;
    uint8_t *rgba;
    float *normals, *full_normals;
    uint8_t *film[TUNE_DOLLY_FRAMES], *judged[2]; /* film: of every sample; judged: before, after */
    double *times;                                /* of one view: by point, then by repeat */
    uint64_t done, total;                         /* number of pictures */
} tune_sweep;

/* Measures everything. params is borrowed. Call clear even after a failure. Errors: those of
 * drawing, CANCELLED, OUT_OF_MEMORY, LIMIT (references would take more than 1 GiB). */
stp_status tune_sweep_run(tune_sweep *sweep, const tune_sweep_params *params, stp_error *err);
void tune_sweep_clear(tune_sweep *sweep);

/* The point of a setting and a threshold. */
tune_point *tune_sweep_point(const tune_sweep *sweep, size_t setting, size_t threshold);
/* Draws the first setting at any thresholds, in turns, in all views. rows: by threshold, then by
 * view; fills compared (if compares), cut, and ms (if repeat > 0). Errors: as above. */
stp_status tune_sweep_probe(tune_sweep *sweep, const double *thresholds, size_t count,
                            bool compares, uint64_t repeat, tune_row *rows, stp_error *err);

#endif
