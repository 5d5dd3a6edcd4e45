/* Checks the error promise of pictures on a sample of drawn discs. For each disc it records the
 * error that the rule predicts, and measures how far the centre and 16 points of the rim lie, on
 * the screen, from the surface of the level-0 discs (tune_nearest.h).
 *
 * Discs are recorded after each picture and measured once at the end, so that each chunk is read a
 * few times at most. Lines and triangles are left out. Threads: the render thread. */
#ifndef STP_TOOLS_TUNE_TUNE_DISCS_H
#define STP_TOOLS_TUNE_TUNE_DISCS_H

#include "runtime/inspect.h"
#include "tools/tune/tune_nearest.h"

#define TUNE_RIM_POINTS 16

/* Why the prediction exceeds the measured error: factors whose product is predicted / measured.
 *   - depth: uses the nearest depth of the patch's bound and of the edge of the field of view
 *     instead of the disc's own depth;
 *   - cone: uses the steepest normal of the cone, seen from anywhere, instead of the disc's own;
 *   - span: uses the stored perpendicular error of a quarter or a patch instead of the greatest
 *     distance of this disc's points along its normal;
 *   - overhang: the same for the stored tangential error;
 *   - rest: adds the two errors, and takes every direction as one across the eye's ray. */
enum { TUNE_DEPTH, TUNE_CONE, TUNE_SPAN, TUNE_OVERHANG, TUNE_REST, TUNE_FACTOR_COUNT };
#define TUNE_FACTOR_NAMES "depth", "cone", "span", "overhang", "rest"

typedef struct tune_disc {
    uint32_t chunk, patch, sample; /* sample: index in the patch's level */
    uint32_t picture, view;        /* numbers of the caller */
    uint8_t level;
    bool random; /* from the random sample; else one of the greatest predictions */
    float predicted_px;
    float scale, sin_alpha, error[2]; /* inputs of the rule */
    /* set by measuring */
    double measured_px; /* negative: all of its points are behind the eye */
    double factor[TUNE_FACTOR_COUNT];
} tune_disc;

typedef struct tune_discs {
    tune_disc *list;
    size_t count, capacity;
} tune_discs;

/* Counts of what a picture drew. */
typedef struct tune_cut {
    uint64_t points, patches, chunks;
    uint64_t exact;      /* points of level 0 of leaves, which are exact */
    uint64_t file_bytes; /* of the chunks, down to the levels drawn */
    uint64_t gpu_bytes;  /* of samples and patches, down to the levels drawn */
    double max_error_px; /* predicted, over all samples that stand for others */
} tune_cut;

/* Counts what the renderer's last picture drew. Adds to discs up to `random` of its discs that
 * stand for others, chosen at random from picture and view, and half as many with the greatest
 * predictions. discs: NULL to count only. Errors: OUT_OF_MEMORY. */
stp_status tune_discs_note(tune_discs *discs, const stp_renderer *renderer, const stp_model *model,
                           uint32_t picture, uint32_t view, size_t random, tune_cut *cut,
                           stp_error *err);
/* Measures all discs. views: by their numbers. Errors: those of tune_nearest_find. */
stp_status tune_discs_measure(tune_discs *discs, const tune_nearest_params *params,
                              const stp_view *views, stp_error *err);
void tune_discs_clear(tune_discs *discs);

#endif
