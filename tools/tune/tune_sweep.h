/* What thresholds cost and buy: named settings of the renderer times thresholds, measured over
 * views against a reference.
 *
 * The reference of a view is every sample (--lod full) drawn with several times as many pixels and
 * averaged, since a plain picture of every sample has steps along its outlines. Normals, and what
 * changes along a dolly, are compared with the plain picture of every sample. References are drawn
 * once and kept, 4 bytes a pixel and view. Threads: the render thread. */
#ifndef STP_TOOLS_TUNE_TUNE_SWEEP_H
#define STP_TOOLS_TUNE_TUNE_SWEEP_H

#include "base/pool.h"
#include "base/progress.h"
#include "tools/compare/compare_metrics.h"
#include "tools/draw/draw_save.h"
#include "tools/tune/tune_discs.h"
#include "tools/tune/tune_metrics.h"
#include "tools/tune/tune_views.h"

/* A way to draw, compared with others at equal points. */
typedef struct tune_setting {
    const char *name;
    stp_draw_params params; /* but the threshold */
} tune_setting;

/* One view at one threshold. */
typedef struct tune_row {
    compare_metrics compared;
    tune_shift shift;
    tune_angles angles;
    tune_cut cut;
    double ms;           /* median of the repeats */
    double predicted_px; /* of the discs measured: greatest; cut.max_error_px is of all drawn */
    double measured_px;  /* greatest */
    uint64_t discs;      /* measured */
    uint32_t passes;
} tune_row;

/* A disc that is no farther off lies on the surface: what was predicted is no number of times that.
 */
#define TUNE_ON_SURFACE_PX 1e-6

/* What stands between predicted and measured, of the random discs of all views that do not lie on
 * the surface: NaN where there are none. */
typedef struct tune_ratios {
    size_t discs, broken;    /* broken: measured above the threshold, of all discs measured */
    double median, p10, p90; /* predicted / measured */
    double factor[TUNE_FACTOR_COUNT]; /* medians */
} tune_ratios;

/* A setting at a threshold. */
typedef struct tune_point {
    double threshold_px;
    tune_row *rows; /* by view */
    tune_change change[TUNE_DOLLIES];
    tune_ratios ratios;
} tune_point;

/* A picture that the page shows, top row first, straight. */
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
    int aa;    /* of the pictures judged: index of DRAW_AA */
    int times; /* the reference's pixels along each side of one */
    const tune_setting *settings;
    size_t setting_count;
    const double *thresholds; /* rising */
    size_t threshold_count;
    uint64_t repeat;     /* timed pictures of each */
    size_t discs;        /* of each picture, random */
    const size_t *shown; /* thresholds whose pictures are kept */
    size_t shown_count;
    const stp_progress *progress;
    stp_pool *pool;
} tune_sweep_params;

typedef struct tune_sweep {
    const tune_sweep_params *params;
    tune_point *points;   /* setting by setting, by threshold */
    uint8_t **references; /* by view, bottom row first, straight */
    tune_discs discs;
    tune_shot shots[TUNE_SHOTS_LIMIT];
    size_t shot_count;
    draw_picture picture;
    uint8_t *rgba;
    float *normals, *full_normals;
    uint8_t *film[TUNE_DOLLY_FRAMES], *judged[2]; /* of every sample; before and after */
    double *times;                                /* of a view: by point, by repeat */
    uint64_t done, total;                         /* pictures */
} tune_sweep;

/* Measures. params is borrowed. Errors: those of drawing, CANCELLED, OUT_OF_MEMORY, LIMIT
 * (references would be more than 1 GiB). Clear in any case. */
stp_status tune_sweep_run(tune_sweep *sweep, const tune_sweep_params *params, stp_error *err);
void tune_sweep_clear(tune_sweep *sweep);

/* The point of a setting and a threshold. */
tune_point *tune_sweep_point(const tune_sweep *sweep, size_t setting, size_t threshold);
/* Draws the first setting at any thresholds, in turns, in all views. rows: by threshold, by view;
 * of them compared (only if compares), cut and ms (if repeat > 0) are filled. Errors: as above. */
stp_status tune_sweep_probe(tune_sweep *sweep, const double *thresholds, size_t count,
                            bool compares, uint64_t repeat, tune_row *rows, stp_error *err);

#endif
