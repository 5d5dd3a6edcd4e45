/* Drawing a model: the renderer that a host application embeds, and that `stipple render` and
 * `stipple view` are made of. This header and those it includes are all of libstipple's interface.
 *
 * Give it a current OpenGL 4.5 context (yours, or one of gl_context.h) and a chunk file. A frame
 * chooses the cut and each patch's levels by projected error, projects one pixel a sample, closes
 * the surface by pull-push and shades it, in textures of its own; stp_renderer_draw_into then takes
 * the picture to your framebuffer, among your triangles. It does not open windows and does not
 * write images. In short, without the checks of what is returned:
 *
 *     stp_model_open(&model, "church.stipple", &err);
 *     stp_renderer_create(&renderer, &(stp_renderer_params){.model = model}, &err);
 *     each frame, your framebuffer being bound and your viewport and depth test set:
 *         your opaque triangles
 *         ball = stp_model_ball(model);
 *         stp_view_from_matrices(&view, model_view, projection, &ball, width, height, &err);
 *         stp_renderer_draw_into(renderer, &view, &(stp_draw_params){.stream = true}, NULL, NULL,
 *                                &err);
 *         more triangles, transparent ones
 *     stp_renderer_destroy(&renderer);
 *     stp_model_close(&model);
 *
 * Axes: the scan's own world axes and units; pictures have their bottom row first, as GL has.
 * Ownership: create and destroy in pairs, which sets NULL; what a parameter struct points to is
 * borrowed. A renderer draws one model, or several (stp_renderer_set_models); a process may have
 * several renderers, also in one context.
 * Errors: a fallible function returns a status and, where err is not NULL, says in err->message
 * what, where, and what to do; its outputs are then untouched. Nothing prints or ends the program.
 * Threads: all calls on a renderer on the thread its context is current on, also destroying it;
 * chunks are read and decoded on threads of its own. A model may be shared by threads.
 *
 * OpenGL state: every call leaves the context as it found it, and needs it in no particular state,
 * but for what GL neither tells nor undoes: conditional rendering must not be active; queries of
 * the host's that run meanwhile (of samples, of time) also count what is drawn here, and while one
 * of GL_PRIMITIVES_GENERATED runs, points_drawn is not known; a program that is in use but deleted
 * is gone, and values of subroutine uniforms are lost; errors that glGetError was not yet asked for
 * are discarded. In a compatibility context, the alpha test must be off. */
#ifndef STP_RUNTIME_STIPPLE_H
#define STP_RUNTIME_STIPPLE_H

#include "base/error.h"
#include "runtime/camera/camera.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- models ---- */

/* A chunk file opened for drawing: its directory in memory. */
typedef struct stp_model stp_model;

/* Reads the directory, no chunk. path, or an http(s):// address: copied. Errors: NOT_FOUND, IO,
 * FORMAT (not a chunk file), VERSION (made by a newer stipple), CORRUPT (where, and what was
 * found), OUT_OF_MEMORY. */
stp_status stp_model_open(stp_model **out, const char *path, stp_error *err);
/* After the renderers that draw it. */
void stp_model_close(stp_model **model);

/* Around all of it: what views are placed by. */
stp_ball stp_model_ball(const stp_model *model);
/* Of the centres of its points. */
stp_dbox stp_model_box(const stp_model *model);
uint64_t stp_model_point_count(const stp_model *model);

/* Where a model is seen from before anyone moves. FIRST: what its file says, from the scanner or
 * within an interior; else WHOLE: all of it from outside, upright as the file says, or else as
 * stp_camera_default. */
typedef enum stp_home { STP_HOME_FIRST = 0, STP_HOME_WHOLE = 1 } stp_home;

/* The camera for a picture of width x height pixels; a scanner's picture is in it whole. */
stp_camera stp_model_camera(const stp_model *model, stp_home home, int width, int height);
/* Bytes of samples and patches that all chunks need on the GPU: a larger gpu_memory_bytes is of no
 * use. */
uint64_t stp_model_gpu_bytes(const stp_model *model);

/* ---- what is drawn ---- */

/* Who chooses the levels. */
typedef enum stp_lod {
    STP_LOD_AUTO = 0,     /* GEOMETRY or COMPUTE, whichever is faster on the driver at hand */
    STP_LOD_GEOMETRY = 1, /* the geometry shader, of patches for which one sample does not do */
    STP_LOD_COMPUTE = 2,  /* a compute shader, of these; compute shaders also project and push */
    STP_LOD_CPU = 3,      /* the same rule on the CPU */
    STP_LOD_FULL = 4      /* nobody: every level-0 sample, in passes if the budget asks for it */
} stp_lod;

#define STP_LOD_LAST STP_LOD_FULL

typedef enum stp_reconstruct {
    STP_RECONSTRUCT_GAUSS = 0, /* MKC08 */
    STP_RECONSTRUCT_BOX = 1,   /* MKC07 */
    /* Mar08, with windows of 3, 5 and 7 pixels: smoother outlines, several times as slow */
    STP_RECONSTRUCT_TEMPLATE3 = 2,
    STP_RECONSTRUCT_TEMPLATE5 = 3,
    STP_RECONSTRUCT_TEMPLATE7 = 4,
    STP_RECONSTRUCT_SPLAT = 5,  /* none: each sample is drawn as an ellipse (Botsch et al. 2005) */
    STP_RECONSTRUCT_POINTS = 6, /* none: one pixel a sample */
    STP_RECONSTRUCT_LAST = STP_RECONSTRUCT_POINTS
} stp_reconstruct;

/* The numbers are STP_SHADE_* of shaders/layout.glsl. */
typedef enum stp_shade {
    STP_SHADE_PHONG = 0,
    STP_SHADE_LAMBERT = 1,
    STP_SHADE_UNLIT = 2, /* colours as they are: for scans that carry their own light */
    STP_SHADE_NORMAL = 3,
    STP_SHADE_DEPTH = 4,
    STP_SHADE_LEVEL = 5,
    STP_SHADE_CHUNK = 6,
    STP_SHADE_ERROR = 7,
    STP_SHADE_CONFIDENCE = 8
} stp_shade;

/* What colours samples. The numbers are STP_COLOUR_* of shaders/layout.glsl. */
typedef enum stp_colour {
    STP_COLOUR_RGB = 0,
    STP_COLOUR_NONE = 1, /* every sample in the same light grey */
    STP_COLOUR_INTENSITY = 2,
    STP_COLOUR_CLASS = 3,
    STP_COLOUR_ELEVATION = 4,
    STP_COLOUR_OUTLIERS = 5, /* samples marked so magenta, others grey by their brightness */
    STP_COLOUR_FIT = 6       /* how normals were found: blue the input's, else the redder, the wider
                                the planes for noise (stp_sample_fit) */
} stp_colour;

/* Of intensity and elevation, low to high. The numbers are STP_PALETTE_* of shaders/layout.glsl. */
typedef enum stp_palette {
    STP_PALETTE_OWN = 0, /* grey for intensity, viridis for elevation */
    STP_PALETTE_GREY = 1,
    STP_PALETTE_VIRIDIS = 2,
    STP_PALETTE_HEAT = 3
} stp_palette;

/* What is left out because its back is turned to the eye. All that is drawn is lit on the side that
 * is seen. */
typedef enum stp_cull {
    STP_CULL_AUTO =
        0, /* only what is proven hidden: in closed surfaces, seen from outside, unclipped */
    STP_CULL_NONE = 1, /* nothing */
    STP_CULL_BACK = 2  /* every sample whose orientation is known: closed or not */
} stp_cull;

/* Samples whose centre lies outside are not drawn; the box's faces belong to it. World coordinates;
 * a side may be infinite. */
typedef struct stp_clip {
    bool enabled;
    stp_dbox box;
} stp_clip;

/* What the error rule sees beside the error of the surface: bits of stp_draw_params.terms. Each
 * makes levels finer where it counts, so whatever it is, no error is beyond the threshold. */
typedef enum stp_term {
    STP_TERM_RADIUS = 1,     /* reconstruction's own limit: the cap on projected radii */
    STP_TERM_COLOUR = 2,     /* what samples average of colours; only where these are shown */
    STP_TERM_SILHOUETTE = 4, /* errors count twice where outlines may be */
    STP_TERM_NONE = 8        /* nothing: the surface's error alone */
} stp_term;
/* Silhouettes are not among them: at equal points outlines gain less than surfaces lose. */
#define STP_TERMS_DEFAULT (STP_TERM_RADIUS | STP_TERM_COLOUR)

/* Zero is the default of each. */
typedef struct stp_draw_params {
    stp_lod lod;
    stp_reconstruct reconstruct;
    stp_shade shade;
    stp_colour colour;
    stp_palette palette;
    uint32_t hidden_models; /* bit i: model i is not drawn */
    double threshold_px;    /* greatest projected error; 0: 1 pixel */
    /* Coarser levels are not drawn larger than this, times the threshold's square where that
     * is above a pixel: then fewer, larger discs are what is asked for; 0: STP_RADIUS_CAP_PX. */
    double radius_cap_px;
    uint32_t terms; /* bit set of stp_term; 0: STP_TERMS_DEFAULT */
    /* Low and high end of the palette: intensity as 0 to 1, elevation in the model's z. The 2nd
     * and the 98th percentile are what a viewer would begin with: stp_model_colour_range. */
    double colour_range[2];
    /* Of STP_SHADE_LEVEL, CHUNK, ERROR and CONFIDENCE: 0 shows their colours alone, unlit; else so
     * much of them, up to 1, is mixed into the samples' colours, which are lit as by PHONG. */
    double overlay;
    double edl; /* eye-dome lighting: 0 none, 1 as other viewers begin, more is darker */
    /* While streaming: share of a level change that a frame still shows of the last one, so that it
     * fades instead of popping, in (0, 1); 0: none. A picture at rest is soon free of it. */
    double fade;
    stp_clip clip;
    uint32_t hidden_classes[8]; /* bit c % 32 of word c / 32: samples of class c are not drawn; a
                                   merged sample has the class of one that it stands for */
    /* Silhouettes cover their pixels in part, as far as discs reach, before what lies behind. Not
     * with POINTS, nor in a host's framebuffer. Depths and picks are as without. */
    bool smooth_edges;
    stp_cull cull;
    bool every_sample; /* threshold zero: all level-0 samples, by whichever road */
    bool stream; /* never waits for chunks: what is missing is drawn from its parent meanwhile */
    bool refine; /* while streaming and nothing changes: on beyond the threshold, to every sample */
    bool keep_pixels; /* finish level 0 of the pyramid too: for normals */
    bool timed;       /* waits for the GPU between stages, so that their times are true */
} stp_draw_params;

#define STP_RADIUS_CAP_PX 6.0

/* What a frame is made of, in this order. */
typedef enum stp_stage {
    STP_STAGE_CHOOSE = 0,  /* levels, by a compute shader; else the shader that projects chooses */
    STP_STAGE_PROJECT = 1, /* to the nearest sample of each pixel */
    STP_STAGE_RESOLVE = 2, /* these samples to pixels */
    STP_STAGE_BLEND = 3,   /* of splats: their sums */
    STP_STAGE_PULL = 4,
    STP_STAGE_PUSH = 5,    /* but to level 0 */
    STP_STAGE_FINISH = 6,  /* the push to level 0, and shading */
    STP_STAGE_EFFECTS = 7, /* eye-dome lighting, smooth edges, normals that are kept */
    STP_STAGE_COUNT
} stp_stage;

/* One word, in lower case. */
const char *stp_stage_name(stp_stage stage);

typedef struct stp_draw_stats {
    /* Choosing, drawing, waiting for the GPU (stp_renderer_draw_into does not wait, so it is this
     * thread's time); not loading nor compiling shaders. */
    double frame_ms;
    double load_ms;                            /* waiting for chunks; none while streaming */
    double project_ms, pull_push_ms, shade_ms; /* where timed; shading includes the last push */
    /* Where timed: of each stage from its begin to its end by the GPU's own clock, 0 where there
     * was none. A software driver's clock is the CPU's, and its stages run on this thread too. */
    double gpu_ms[STP_STAGE_COUNT];
    /* By GEOMETRY and COMPUTE: what is not dropped out of sight or culled, but for patches of one
     * sample, which all count; of splats and by other roads: what is sent to projection. 0 where
     * that is not known without waiting. */
    uint64_t points_drawn;
    uint32_t chunks_drawn, chunks_missing;
    uint32_t chunks_loading; /* on their way; 0 with some missing: there is no room for them */
    uint32_t passes;
    stp_lod lod; /* the one that was taken: never AUTO */
    int pyramid_levels;
    bool cut_complete;
    bool more;         /* while streaming: the next frame may show more without any chunk coming */
    bool fading;       /* the next frame shows less of level changes */
    bool every_sample; /* nothing finer is in the model's files */
} stp_draw_stats;

/* Memory in use and what is allotted to a renderer, bytes; constant but for gpu_used. */
typedef struct stp_memory_use {
    uint64_t gpu_used, gpu_allotted, cpu_allotted;
} stp_memory_use;

/* What the rule chose for the last frame, recomputed on the CPU patch by patch. */
typedef struct stp_cut_measure {
    uint64_t points, patches;
    double max_error_px; /* greatest projected error chosen; unbounded patches are drawn finest */
} stp_cut_measure;

/* The 2nd and 98th percentile of intensity or elevation, of the samples of the model's root: what
 * colour_range may be set to. Errors: those of reading a chunk. */
stp_status stp_model_colour_range(const stp_model *model, stp_colour colour, double range[2],
                                  stp_error *err);

/* How the model is meant to be shown: UNLIT if `prep --shade unlit` made it so, else PHONG. */
stp_shade stp_model_shade(const stp_model *model);

/* ---- renderers ---- */

typedef struct stp_renderer stp_renderer;

typedef struct stp_renderer_params {
    const stp_model *model;    /* borrowed; outlives the renderer */
    uint64_t gpu_memory_bytes; /* of samples and patches; 0: 1 GiB */
    uint64_t cpu_memory_bytes; /* of payloads, patches and chunks being decoded; 0: 1 GiB */
    unsigned thread_count;     /* for decoding; 0: one per processor */
    const char *shader_folder; /* files there win over the embedded ones; may be NULL */
    /* Called from another thread when a frame that streams would show more; must not call back. */
    void (*wake)(void *);
    void *wake_context;
} stp_renderer_params;

/* Errors: GL (no current 4.5 context), LIMIT (budget too small), NOT_FOUND (shader_folder),
 * OUT_OF_MEMORY, and those of reading the root chunk. */
stp_status stp_renderer_create(stp_renderer **out, const stp_renderer_params *params,
                               stp_error *err);
void stp_renderer_destroy(stp_renderer **renderer);

/* Replaces the models that are drawn, all in one picture; they are borrowed and outlive the
 * renderer. Their roots are loaded anew. On failure those before are drawn on; if they cannot be
 * read again either, which is IO, drawing fails until this succeeds. Errors: those of
 * stp_renderer_create; INVALID_ARGUMENT (none, more than 32). */
stp_status stp_renderer_set_models(stp_renderer *renderer, const stp_model *const *models,
                                   size_t count, stp_error *err);

/* Draws into the renderer's own picture, of the view's size. stats may be NULL. A damaged chunk is
 * no error: its parent is drawn and stp_renderer_damage says so. Programs are compiled for the
 * parameters, anew when those of the last frame do not do. Errors: GL (a shader), IO, LIMIT,
 * OUT_OF_MEMORY; INVALID_ARGUMENT (a clip box that is inverted or not a number, overlay, edl or
 * fade out of range). */
stp_status stp_renderer_draw(stp_renderer *renderer, const stp_view *view,
                             const stp_draw_params *params, stp_draw_stats *stats, stp_error *err);

/* How a picture lands in the host's framebuffer. Zero is the default. */
typedef struct stp_target {
    /* The host's framebuffer holds light, as floating-point ones of a lit scene do: the picture's
     * colours, which are encoded for screens (sRGB), are decoded. Else they are written as they
     * are, without GL_FRAMEBUFFER_SRGB. */
    bool linear_light;
} stp_target;

/* Draws as stp_renderer_draw does, then into the host's framebuffer as one draw call of the host's
 * would: into the framebuffer that is bound for drawing, within viewport 0, under the scissor, the
 * stencil test, the depth test and function, the depth mask, the colour mask, the depth range and
 * the clip control that are set. Only covered pixels are touched, each with its own depth; so
 * points hide what the host has drawn or draws later, and are hidden by it. Enable GL_DEPTH_TEST,
 * and draw before what blends.
 *
 * view: of stp_view_from_matrices, of the viewport's size; what lies outside the projection's depth
 * range is cut away unless GL_DEPTH_CLAMP is on. Colour goes to the first draw buffer, alpha is 1,
 * nothing is blended. A multisampled framebuffer gets the same colour and depth in each sample of a
 * pixel. Does not wait for the GPU; with params->stream it does not wait for chunks either and
 * draws what is there, which stats->cut_complete tells (draw again then). target, stats may be
 * NULL. Errors: as stp_renderer_draw; INVALID_ARGUMENT (view or viewport), UNSUPPORTED (framebuffer
 * not complete, or of integers); then the host's framebuffer is untouched. */
stp_status stp_renderer_draw_into(stp_renderer *renderer, const stp_view *view,
                                  const stp_draw_params *params, const stp_target *target,
                                  stp_draw_stats *stats, stp_error *err);

/* The last picture: width * height * 4 bytes RGBA, bottom row first, alpha 255 where covered, and
 * less at smooth edges, where colours are premultiplied by it. */
stp_status stp_renderer_read(stp_renderer *renderer, uint8_t *rgba, stp_error *err);

/* Depth of the last picture at a pixel (bottom row first), along the camera's axis; 0 where nothing
 * is. Errors: INVALID_ARGUMENT (outside the picture), GL. */
stp_status stp_renderer_depth_at(stp_renderer *renderer, int x, int y, float *depth,
                                 stp_error *err);

#define STP_PICK_NO_CHUNK UINT32_MAX

/* What a picture shows at a pixel. */
typedef struct stp_pick {
    bool hit; /* false: nothing is there, and nothing else is said */
    /* Where the ray through the pixel's centre meets the surface; no farther than a radius from the
     * centre of the nearest sample drawn, so at outlines a little beside the ray. */
    stp_dvec3 position;
    double depth, depth_end; /* the interval of the front surface along the camera's axis */
    stp_dvec3 normal;        /* of the surface, unit, world axes; turned to the eye if two-sided */
    uint8_t rgb[3];          /* of the surface, unlit: what colour and overlay made of it */
    bool interpolated;       /* no sample fell on this pixel, or one behind the front surface */
    int pyramid_level;       /* that the pixel comes from; 0: measured */
    /* Of the nearest sample drawn. All but the radius is not known of a picture made in several
     * passes, and of chunks that gave way to others since: then chunk is STP_PICK_NO_CHUNK. */
    double radius; /* world units */
    uint32_t chunk;
    int level; /* of its patch, 0 the finest; -1: not known */
    uint8_t class_id;
    double intensity; /* 0 to 1 */
} stp_pick;

/* Picks the front surface of the last picture at a pixel (bottom row first); what lies behind it is
 * never taken. A pixel where nothing is takes the nearest that is covered, up to two pixels away:
 * outlines and pinholes can be picked. Leaves the picture as it is; but while refine (or a budget)
 * makes a still picture of passes, the frame before it is drawn anew and the passes begin again.
 * Errors: INVALID_ARGUMENT (outside the picture), GL, OUT_OF_MEMORY. */
stp_status stp_renderer_pick(stp_renderer *renderer, int x, int y, stp_pick *out, stp_error *err);
/* Depths of the last picture, width * height floats, bottom row first, as stp_renderer_depth_at's.
 * Errors: LIMIT (2 GiB of them), GL. */
stp_status stp_renderer_read_depth(stp_renderer *renderer, float *depth, stp_error *err);

/* Normals of the last picture, which was drawn with keep_pixels: width * height * 3 floats, bottom
 * row first, unit vectors in the world's axes, turned to the viewer where both sides are drawn;
 * 0 0 0 where nothing is. Errors: INVALID_ARGUMENT (drawn without keep_pixels), OUT_OF_MEMORY, GL.
 */
stp_status stp_renderer_read_normals(stp_renderer *renderer, float *xyz, stp_error *err);

/* Copies the last picture to the lower left corner of a framebuffer (0: the window's). */
void stp_renderer_present(stp_renderer *renderer, unsigned framebuffer, int width, int height);

/* Recomputes the last frame's choice. Not for STP_LOD_FULL with several passes. */
void stp_renderer_measure(const stp_renderer *renderer, stp_cut_measure *out);

/* Compiles the shaders anew (from the folder, if one was given). On failure the old ones stay.
 * Errors: GL. */
stp_status stp_renderer_reload_shaders(stp_renderer *renderer, stp_error *err);

/* The first damage met while reading chunks, as a sentence, and of how many besides; empty if none.
 */
const char *stp_renderer_damage(const stp_renderer *renderer);
/* Why chunks that are missing do not come at the moment, as a sentence; empty if they do. */
const char *stp_renderer_trouble(const stp_renderer *renderer);
uint64_t stp_renderer_bytes_read(const stp_renderer *renderer);
stp_memory_use stp_renderer_memory(const stp_renderer *renderer);
/* Whether a frame that streams would take in what the last one had not. */
bool stp_renderer_has_news(const stp_renderer *renderer);

#ifdef __cplusplus
}
#endif

#endif
