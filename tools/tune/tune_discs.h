/* The error promise of what was drawn: a sample of drawn discs, what the rule predicts of each, and
 * how far its centre and 16 points of its rim really lie, on the screen, from the surface of the
 * discs of level 0 (tune_nearest.h).
 *
 * Noted after each picture, measured once at the end, so that each chunk is read a few times at
 * most. Lines and triangles are left out. Threads: the render thread. */
#ifndef STP_TOOLS_TUNE_TUNE_DISCS_H
#define STP_TOOLS_TUNE_TUNE_DISCS_H

#include "runtime/inspect.h"
#include "tools/tune/tune_nearest.h"

#define TUNE_RIM_POINTS 16

/* Why the prediction is more than what was measured: factors whose product is predicted / measured.
 * depth: of the nearest depth of the patch's bound and the edge of the field of view, for the
 * disc's own; cone: of the steepest normal of the cone, seen from anywhere, for the disc's own;
 * span: of the stored perpendicular error, a quarter's or a patch's, for the greatest distance of
 * this disc's points along its normal; overhang: of the stored tangential error, likewise; rest: of
 * adding the two and of taking every direction for one across the eye's ray. */
enum { TUNE_DEPTH, TUNE_CONE, TUNE_SPAN, TUNE_OVERHANG, TUNE_REST, TUNE_FACTOR_COUNT };
#define TUNE_FACTOR_NAMES "depth", "cone", "span", "overhang", "rest"

typedef struct tune_disc {
    uint32_t chunk, patch, sample; /* sample: of its level of the patch */
    uint32_t picture, view;        /* the caller's numbers */
    uint8_t level;
    bool random; /* of the random sample; else of those of greatest prediction */
    float predicted_px;
    float scale, sin_alpha, error[2]; /* what the rule had */
    /* once measured */
    double measured_px; /* negative: none of its points is in front of the eye */
    double factor[TUNE_FACTOR_COUNT];
} tune_disc;

typedef struct tune_discs {
    tune_disc *list;
    size_t count, capacity;
} tune_discs;

/* What a picture drew. */
typedef struct tune_cut {
    uint64_t points, patches, chunks;
    uint64_t exact;      /* points of level 0 of leaves, which stand for themselves */
    uint64_t file_bytes; /* of the chunks, down to the levels drawn */
    uint64_t gpu_bytes;  /* likewise, of samples and patches */
    double max_error_px; /* predicted, of all that stands for others */
} tune_cut;

/* Counts what the renderer's last picture drew, and adds up to `random` of its discs that stand for
 * others, chosen at random by picture and view, and half as many of the greatest prediction.
 * discs: NULL to count alone. Errors: OUT_OF_MEMORY. */
stp_status tune_discs_note(tune_discs *discs, const stp_renderer *renderer, const stp_model *model,
                           uint32_t picture, uint32_t view, size_t random, tune_cut *cut,
                           stp_error *err);
/* Measures all. views: by their numbers. Errors: those of tune_nearest_find. */
stp_status tune_discs_measure(tune_discs *discs, const tune_nearest_params *params,
                              const stp_view *views, stp_error *err);
void tune_discs_clear(tune_discs *discs);

#endif
