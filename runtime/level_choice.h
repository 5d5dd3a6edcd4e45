/* The level of a patch, chosen on the CPU: shaders/choose.glsl in C, on the same floats.
 *
 * Also the rule for whole chunks, from which the cut is made. Threads: any (pure functions). */
#ifndef STP_RUNTIME_LEVEL_CHOICE_H
#define STP_RUNTIME_LEVEL_CHOICE_H

#include "runtime/camera.h"
#include "runtime/gpu_layout.h"

#define STP_LEVEL_SKIP (-1)

/* What the shaders read of a frame, from the view. modes and quality[0..1] are the caller's. */
stp_gpu_frame stp_gpu_frame_from_view(const stp_view *view);

/* Level to draw, or STP_LEVEL_SKIP if the patch is out of sight or its child is drawn instead. */
int stp_level_choose(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                     const stp_gpu_patch *patch);

/* Projected error of a patch at a level, pixels; 0 where nothing bounds the projection (then the
 * finest level is drawn). */
float stp_level_error_px(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                         const stp_gpu_patch *patch, int level);

/* A bound as the rule sees it: ball relative to the eye (world axes), cone of normals. */
typedef struct stp_rule_bound {
    float centre[3], radius;
    float cone_axis[3], cone_cos;
    bool two_sided;
} stp_rule_bound;

typedef struct stp_rule_sight {
    bool visible;    /* not outside the frustum, not seen from behind */
    float scale;     /* pixels per unit at most; -1: must refine */
    float sin_alpha; /* greatest sine between eye ray and normal */
} stp_rule_sight;

/* Culls a bound and gives what stp_rule_error needs. */
stp_rule_sight stp_rule_look(const stp_gpu_frame *frame, const stp_rule_bound *bound);

#endif
