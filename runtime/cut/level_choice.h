/* The levels of a patch, chosen on the CPU: shaders/project/choose.glsl in C, on the same floats.
 *
 * Also the rule for whole chunks, from which the cut is made. Threads: any (pure functions). */
#ifndef STP_RUNTIME_CUT_LEVEL_CHOICE_H
#define STP_RUNTIME_CUT_LEVEL_CHOICE_H

#include "base/vec.h"
#include "formats/chunk/chunk_file.h"
#include "runtime/camera/camera.h"
#include "runtime/gl/gpu_layout.h"
#include "runtime/stream/range_pool.h"

#define STP_LEVEL_SKIP (-1)

/* What the shaders read of a frame, from the view. modes, quality[0..1], colours, clip box and
 * classes are the caller's. */
stp_gpu_frame stp_gpu_frame_from_view(const stp_view *view);

/* By quarter (formats/chunk/sample.h); STP_LEVEL_SKIP for what is not there. Level 3
 * stands for the whole patch, in quarter 0. */
typedef struct stp_levels {
    int of[STP_PATCH_QUARTERS];
} stp_levels;

/* Levels to draw of a patch in sight. */
stp_levels stp_levels_choose(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                             const stp_gpu_patch *patch);

/* The samples of the levels chosen as stretches of the Object Texture, joined where one goes on
 * where another ends. Returns how many. */
unsigned stp_levels_select(const stp_gpu_patch *patch, const stp_levels *levels,
                           stp_range out[STP_PATCH_QUARTERS]);

/* What a patch of these levels is drawn as: STP_PATCH_STRIP, a polyline, STP_PATCH_TRIANGLES, or,
 * 0, points. All quarters of a strip or of triangles choose the same level. */
unsigned stp_levels_shape(const stp_gpu_patch *patch, const stp_levels *levels);

/* Projected error of a quarter at a level, pixels; at levels 0 and 3 of the patch. 0 where nothing
 * bounds the projection (then the finest level is drawn). */
float stp_level_error_px(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                         const stp_gpu_patch *patch, int level, int quarter);

/* Of the error rule's terms (stp_rule_fits). Colours: measured, `stipple tune --terms`; 2 to 4 gain
 * as much, 10 loses. */
#define STP_COLOUR_WEIGHT 4.0f
#define STP_SILHOUETTE_WEIGHT 2.0f

/* A bound as the rule sees it: ball relative to the eye (world axes), cone of normals. */
typedef struct stp_rule_bound {
    float centre[3], radius;
    float cone_axis[3], cone_cos;
    bool two_sided, closed;
} stp_rule_bound;

typedef struct stp_rule_sight {
    float scale;        /* pixels per unit at most; -1: must refine */
    float sin_alpha;    /* greatest sine between eye ray and normal */
    float error_weight; /* more than 1 where outlines may be, if that is a term of the rule */
} stp_rule_sight;

/* The ball around a chunk's samples, relative to the eye. */
stp_ball stp_entry_ball(const stp_chunk_entry *entry, stp_dvec3 eye);

/* What is asked of every patch of a cut, apart from the rest of its record: this is read for some
 * hundred thousand patches a frame. */
typedef struct stp_patch_brief {
    stp_rule_bound bound;                                   /* relative to its chunk's origin */
    float vertex_error[2], vertex_radius, vertex_variation; /* of level 3 */
    /* Which child of its chunk refines it; in a linked chunk which of the child's patches do. */
    uint8_t child, below_count;
    uint16_t first_below;
    uint8_t shape; /* STP_PATCH_STRIP, STP_PATCH_TRIANGLES or neither */
} stp_patch_brief;

stp_patch_brief stp_patch_brief_of(const stp_gpu_patch *patch, const stp_patch *stored);
/* A patch's bound, relative to the eye. */
stp_rule_bound stp_patch_bound(const stp_patch_brief *brief, const stp_gpu_chunk *chunk);

/* Whether the finest level drawn of its chunk does for all of a patch in sight. */
bool stp_finest_does(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                     const stp_gpu_patch *patch, int finest);
/* Whether level 3, the patch's vertex, does for all of it. */
bool stp_vertex_does(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                     const stp_patch_brief *brief);

/* Not outside the frustum or the clip box, nor seen from behind all over. eye: then gets the centre
 * in eye space. */
bool stp_rule_visible(const stp_gpu_frame *frame, const stp_rule_bound *bound, float eye[3]);
/* What stp_rule_error needs of a bound. */
stp_rule_sight stp_rule_look(const stp_gpu_frame *frame, const stp_rule_bound *bound);

#endif
