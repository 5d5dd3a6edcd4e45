/* Chooses the levels of a patch on the CPU: shaders/project/choose.glsl in C, on the same floats.
 *
 * Also applies the rule to whole blocks, to make the cut. Threads: any (pure functions). */
#ifndef STP_RUNTIME_CUT_LEVEL_CHOICE_H
#define STP_RUNTIME_CUT_LEVEL_CHOICE_H

#include "base/vec.h"
#include "formats/chunk/chunk_file.h"
#include "runtime/camera/camera.h"
#include "runtime/cut/scene.h"
#include "runtime/gl/gpu_layout.h"
#include "runtime/stream/cache/range_pool.h"

#define STP_LEVEL_SKIP (-1)

/* A patch as the CPU keeps it while its block is on the GPU: stp_gpu_patch, decoded. Positions are
 * relative to the chunk's origin. */
typedef struct stp_mirror_patch {
    float origin[3], step;
    float bound_centre[3], bound_radius;
    float cone_axis[3], cone_cos;
    float vertex_error[2]; /* of level 3: perpendicular, tangential */
    float finest_error[2]; /* of level 0: perpendicular, tangential */
    float radius[STP_LEVEL_COUNT];
    uint32_t number; /* in the Object Texture */
    uint8_t count[STP_LEVEL_COUNT];
    uint8_t finest; /* resident level */
    uint8_t flags;  /* STP_PATCH_* */
    uint16_t spots; /* of a wide patch: 1 + the number of its first spot (stream/spots.h); else 0 */
    uint8_t colour_error[STP_LEVEL_COUNT];
    /* Levels 2, then 1: perpendicular, tangential; by quarter. */
    float quarter_error[2][2][STP_PATCH_QUARTERS];
} stp_mirror_patch;

/* Fills in what the shaders read about a view. The caller sets modes, quality[0..1], colours, clip
 * box and classes. */
stp_gpu_frame stp_gpu_frame_from_view(const stp_view *view);

/* Makes heights so many times as high. Everything relative to the eye is then relative to where the
 * eye is in the world as it is (stp_unexaggerated): lines of sight stay what they are, so culling,
 * clip box and openings ask the world as it is. Only eye space is stretched, and with it errors,
 * radii and bounds, by at most max(1, times). */
void stp_gpu_frame_exaggerate(stp_gpu_frame *frame, double times);

/* The level of each quarter (formats/chunk/sample/sample.h); STP_LEVEL_SKIP: the quarter does not
 * exist, or quarter 0 draws level 3, which stands for the whole patch. */
typedef struct stp_levels {
    int of[STP_PATCH_QUARTERS];
} stp_levels;

/* The levels to draw of a patch in sight: those that the rule asks for, but none finer than is
 * drawn of the chunk or is resident of the patch. */
stp_levels stp_levels_choose(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                             const stp_mirror_patch *patch);

/* The finest level of a patch that can be drawn if the chunk is drawn at levels >= finest. */
static inline int stp_level_resident(const stp_mirror_patch *patch, int finest)
{
    return finest > patch->finest ? finest : patch->finest;
}

/* The samples of the chosen levels as ranges of names; adjacent ranges are joined. Returns the
 * number of ranges. */
unsigned stp_levels_select(const stp_mirror_patch *patch, const stp_levels *levels,
                           stp_range out[STP_PATCH_QUARTERS]);

/* What a patch with these levels is drawn as: STP_PATCH_STRIP (a polyline), STP_PATCH_TRIANGLES, or
 * 0 (points). All quarters of a strip or of triangles choose the same level. */
unsigned stp_levels_shape(const stp_mirror_patch *patch, const stp_levels *levels);

/* The projected error of a quarter at a level, pixels; at levels 0 and 3 that of the whole patch. 0
 * if nothing bounds the projection (the finest level is drawn then). */
float stp_level_error_px(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                         const stp_mirror_patch *patch, int level, int quarter);

/* Weights of the error rule's terms (stp_rule_fits). The weight of colours was measured by `stipple
 * tune --terms`: 2 to 4 gain equally, 10 loses. */
#define STP_COLOUR_WEIGHT 4.0f
#define STP_SILHOUETTE_WEIGHT 2.0f

/* A bound as the rule reads it: a ball relative to the eye (world axes), and a cone of normals. */
typedef struct stp_rule_bound {
    float centre[3], radius;
    float cone_axis[3], cone_cos;
    bool two_sided, closed;
} stp_rule_bound;

typedef struct stp_rule_sight {
    float scale;        /* greatest pixels per unit; -1: must refine */
    float sin_alpha;    /* greatest sine of the angle between eye ray and normal */
    float error_weight; /* above 1 if the silhouette term is on and outlines may be here */
} stp_rule_sight;

/* How many times as long as it is anything is drawn at most. */
static inline float stp_frame_stretch(const stp_gpu_frame *frame)
{
    return frame->centre[2] > 1.0f ? frame->centre[2] : 1.0f;
}

/* The ball around a block's samples, relative to the eye. origin: of its chunk. */
stp_ball stp_block_ball(const stp_block *block, stp_dvec3 origin, stp_dvec3 eye);

/* Unit of stp_patch_brief.quarter_radius. */
#define STP_BRIEF_RADIUS (1.0f / 64.0f)

/* The part of a patch's record that is read for every patch of a cut. It is kept apart, since a
 * frame reads some hundred thousand of them. */
typedef struct stp_patch_brief {
    stp_rule_bound bound;                 /* relative to the chunk's origin */
    float vertex_error[2], vertex_radius; /* of level 3 */
    /* The block that refines the patch (stp_scene_block_below), and which of its patches. */
    uint32_t block;
    uint16_t first_below;
    /* Of level 2, rounded up: the greatest errors of any quarter, as the upper halves of floats;
     * the radius, in 64ths of vertex_radius. */
    uint16_t quarter_error[2];
    uint8_t quarter_radius;
    uint8_t colour_error[2]; /* of levels 3 and 2 */
    uint8_t below_count;
    uint8_t empty;            /* bit l: no sample of level l is drawn (runtime/stream/chosen.h) */
    uint8_t shape : 3;        /* STP_PATCH_STRIP, STP_PATCH_TRIANGLES or neither */
    uint8_t finest : 2;       /* resident level */
    bool has_spots : 1;       /* stp_mirror_patch.spots */
    bool vertex_greatest : 1; /* no level has a greater radius than vertex_radius */
} stp_patch_brief;

/* chunk: that of the patch, by its number in the scene. */
stp_patch_brief stp_patch_brief_of(const stp_scene *scene, uint32_t chunk,
                                   const stp_mirror_patch *patch, const stp_patch *stored);
/* The bound of a patch, relative to the eye. */
stp_rule_bound stp_patch_bound(const stp_patch_brief *brief, const stp_gpu_chunk *chunk);

/* Whether some level, not finer than `finest`, does for each quarter of a patch. It need not be the
 * finest: a few samples of level 0 may be wider than all of level 1. Levels that do not matter may
 * thus be missing. */
bool stp_levels_do(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                   const stp_mirror_patch *patch, int finest);
/* The finest level that the rule asks of a patch, not finer than `finest`; STP_LEVEL_COUNT - 1 if
 * the patch vertex will do. */
int stp_level_asked(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                    const stp_mirror_patch *patch, int finest);
/* The same, if how the eye sees the patch is known. */
int stp_level_asked_seen(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                         const stp_mirror_patch *patch, int finest);

/* The first opening of the frame, from opening i on, that lies between the eye and any place in a
 * ball; modes[3] if none does. */
int stp_opening_next(const stp_gpu_frame *frame, int i, const float centre[3], float radius);

/* Where a ball in eye space may appear: a disc in the window, pixels. */
typedef struct stp_window_disc {
    float centre[2], reach; /* infinite if nothing bounds the projection */
} stp_window_disc;
stp_window_disc stp_ball_window_disc(const stp_gpu_frame *frame, const float eye[3], float radius);

/* False if the bound lies outside the frustum or the clip box, or shows only backs that are hidden.
 * If true, eye gets the bound's centre in eye space. */
bool stp_rule_visible(const stp_gpu_frame *frame, const stp_rule_bound *bound, float eye[3]);
/* The same of a patch's bound. */
bool stp_patch_visible(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                       const stp_mirror_patch *patch);
/* How the eye sees some patches of a block, found side by side: eight at a time, or four. */
enum { STP_LOOKS_LIMIT = 64 };
typedef struct stp_looks {
    float eye[3][STP_LOOKS_LIMIT];                               /* stp_rule_visible */
    float window[2][STP_LOOKS_LIMIT], reach_px[STP_LOOKS_LIMIT]; /* stp_window_disc */
    float scale[STP_LOOKS_LIMIT], sin_alpha[STP_LOOKS_LIMIT];    /* stp_rule_look */
    uint32_t visible[STP_LOOKS_LIMIT];
    uint32_t vertex[STP_LOOKS_LIMIT];   /* level 3, the patch vertex, does for all of the patch */
    uint32_t quarters[STP_LOOKS_LIMIT]; /* level 2 does for sure; if not, it still may */
} stp_looks;

/* Looks at up to STP_LOOKS_LIMIT patches: what the functions named above say of each patch, to the
 * last bit. openings: the frame, with the openings that matter alone (runtime/cut/culling.h).
 * Places are set of those that are not visible, too. */
void stp_patches_look(stp_looks *out, const stp_gpu_frame *frame, const stp_gpu_frame *openings,
                      const stp_gpu_chunk *chunk, const stp_patch_brief *briefs, uint32_t count);
/* What stp_rule_look says of a patch that was looked at. */
stp_rule_sight stp_looks_sight(const stp_looks *looks, const stp_gpu_frame *frame, uint32_t i);
/* Whether every normal in the bound turns to every eye ray through it: none of its backs is seen.
 */
bool stp_rule_faces_eye(const stp_gpu_frame *frame, const stp_rule_bound *bound);
/* Computes what stp_rule_error needs about a bound. */
stp_rule_sight stp_rule_look(const stp_gpu_frame *frame, const stp_rule_bound *bound);

#endif
