/* The public API of libstipple: opens models and draws them. A host application embeds this
 * renderer; `stipple render` and `stipple view` are built on it. This header and the headers it
 * includes are the whole interface.
 *
 * You provide a current OpenGL 4.5 context (your own, or one of gl_context.h) and a chunk file.
 * To draw a frame, the renderer
 *
 *     1. chooses the cut, and the level of each patch by its projected error;
 *     2. projects each sample to one pixel;
 *     3. closes the surface by pull-push;
 *     4. shades the surface, in textures of its own.
 *
 * Then stp_renderer_draw_into copies the picture to your framebuffer, among your triangles. The
 * renderer opens no windows and writes no images. In short, without error checks:
 *
 *     stp_model_open(&model, "church.stipple", &err);
 *     stp_renderer_create(&renderer, &(stp_renderer_params){.model = model}, &err);
 *     each frame, with your framebuffer bound and your viewport and depth test set:
 *         your opaque triangles
 *         ball = stp_model_ball(model);
 *         stp_view_from_matrices(&view, model_view, projection, &ball, width, height, &err);
 *         stp_renderer_draw_into(renderer, &view, &(stp_draw_params){.stream = true}, NULL, NULL,
 *                                &err);
 *         more triangles, transparent ones
 *     stp_renderer_destroy(&renderer);
 *     stp_model_close(&model);
 *
 * Axes: world axes and units are the scan's own. Pictures have their bottom row first, as in GL.
 * Ownership: call create and destroy (open and close) in pairs; destroy and close set the pointer
 * to NULL. Whatever a parameter struct points to is borrowed. A renderer draws one model, or
 * several (stp_renderer_set_models). A process may have several renderers, also in one context.
 * Errors: a function that can fail returns a status. If err is not NULL, err->message says what
 * failed, where, and what to do. A function that fails leaves its outputs untouched. No function
 * prints or ends the program.
 * Threads: call a renderer, including its destroy, only on the thread where its context is current.
 * The renderer reads and decodes blocks of chunks on threads of its own. Threads may share a model.
 *
 * OpenGL state: every call accepts any state of the context and leaves the state as it was. The
 * exceptions are what GL can neither report nor restore:
 *   - Conditional rendering must not be active.
 *   - In a compatibility context, the alpha test must be off.
 *   - Host queries that run during a call (samples, time) also count the renderer's work. While a
 *     query of GL_PRIMITIVES_GENERATED runs, points_drawn is unknown.
 *   - A program that is in use but already deleted is lost, and so are subroutine uniform values.
 *   - On a software driver, creating a renderer or choosing models leaves no buffer bound to
 *     GL_EXTERNAL_VIRTUAL_MEMORY_BUFFER_AMD.
 *   - Errors that the host has not yet fetched with glGetError are discarded. */
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

/* A chunk file opened for drawing. Holds the file's directory in memory. */
typedef struct stp_model stp_model;

/* Opens a file path or an http(s):// address; the string is copied. Reads the directory and no
 * chunks. Errors: NOT_FOUND, IO, FORMAT (not a chunk file), VERSION (made by a newer stipple),
 * CORRUPT (says where, and what was found), OUT_OF_MEMORY. */
stp_status stp_model_open(stp_model **out, const char *path, stp_error *err);
/* Destroy the renderers that draw the model first. */
void stp_model_close(stp_model **model);

/* A ball around the whole model. Views are placed by it. */
stp_ball stp_model_ball(const stp_model *model);
/* The bounding box of the centres of the model's points. */
stp_dbox stp_model_box(const stp_model *model);
uint64_t stp_model_point_count(const stp_model *model);

/* The view of a model before anyone moves the camera.
 * FIRST: the view that the file names: from the scanner, or from within an interior. If the file
 * names none, as WHOLE.
 * WHOLE: all of the model from outside. If the file says which way is up, that way is up; otherwise
 * as stp_camera_default. */
typedef enum stp_home { STP_HOME_FIRST = 0, STP_HOME_WHOLE = 1 } stp_home;

/* The camera for a picture of width x height pixels. All of a scanner's picture is in view. */
stp_camera stp_model_camera(const stp_model *model, stp_home home, int width, int height);
/* Shows an attribute that prep kept (--attributes) in place of intensities: draw the model with
 * STP_COLOUR_INTENSITY and colour_range 0 to 1. Call it before a renderer has the model, once.
 * range: the values at the palette's ends; if they do not rise, the 2nd and 98th percentile are
 * set. Samples without a value are at the low end. Errors: NOT_FOUND (no such attribute; the
 * message names all), INVALID_ARGUMENT (colours and intensities are shown without it), those of
 * reading. */
stp_status stp_model_show_attribute(stp_model *model, const char *name, double range[2],
                                    stp_error *err);
/* Draws only the samples that fulfil a condition, such as "class==2 && intensity>=200" or, on kept
 * attributes, "return_number==1" (docs/drawing.md, "Conditions"). Each sample of each level
 * is asked; so that none that stands for several points is large, the radius cap is then
 * STP_RADIUS_CAP_CHOSEN_PX, unless the draw parameters give one. Call it before a renderer has the
 * model, once. Errors: INVALID_ARGUMENT (not a condition, or a name that the model does not have;
 * the message says where, and what it has), those of reading. */
stp_status stp_model_choose(stp_model *model, const char *condition, stp_error *err);

/* ---- what is drawn ---- */

/* How levels are chosen. */
typedef enum stp_lod {
    STP_LOD_AUTO = 0,     /* GEOMETRY or COMPUTE, whichever is faster on the driver at hand */
    STP_LOD_GEOMETRY = 1, /* the geometry shader, except patches that the CPU draws as one sample */
    STP_LOD_COMPUTE = 2,  /* a compute shader, likewise; compute shaders also project and push */
    STP_LOD_CPU = 3,      /* the CPU, by the same rule */
    STP_LOD_FULL = 4      /* no choice: every level-0 sample, in passes if memory is short */
} stp_lod;

#define STP_LOD_LAST STP_LOD_FULL

typedef enum stp_reconstruct {
    STP_RECONSTRUCT_GAUSS = 0, /* MKC08 */
    STP_RECONSTRUCT_BOX = 1,   /* MKC07 */
    /* Mar08, with windows of 3, 5 and 7 pixels: smoother outlines, several times as slow */
    STP_RECONSTRUCT_TEMPLATE3 = 2,
    STP_RECONSTRUCT_TEMPLATE5 = 3,
    STP_RECONSTRUCT_TEMPLATE7 = 4,
    STP_RECONSTRUCT_SPLAT = 5,  /* no pull-push: each sample is an ellipse (Botsch et al. 2005) */
    STP_RECONSTRUCT_POINTS = 6, /* no pull-push: one pixel a sample */
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
    STP_SHADE_CONFIDENCE = 8,
    STP_SHADE_PRIMITIVE = 9, /* what samples are drawn as: points, lines, triangles */
    STP_SHADE_LAST = STP_SHADE_PRIMITIVE
} stp_shade;

/* The source of the samples' colours. The numbers are STP_COLOUR_* of shaders/layout.glsl. */
typedef enum stp_colour {
    STP_COLOUR_RGB = 0,
    STP_COLOUR_NONE = 1, /* every sample in the same light grey */
    STP_COLOUR_INTENSITY = 2,
    STP_COLOUR_CLASS = 3,
    STP_COLOUR_ELEVATION = 4,
    STP_COLOUR_OUTLIERS = 5, /* magenta: marked as outliers; others: grey by their brightness */
    STP_COLOUR_FIT = 6       /* how the normal was found (stp_sample_fit). Blue: given by the input.
                                Otherwise the redder, the wider the plane that evens out noise */
} stp_colour;

/* Colours of intensity and elevation, from low to high. The numbers are STP_PALETTE_* of
 * shaders/layout.glsl. */
typedef enum stp_palette {
    STP_PALETTE_OWN = 0, /* grey for intensity, viridis for elevation */
    STP_PALETTE_GREY = 1,
    STP_PALETTE_VIRIDIS = 2,
    STP_PALETTE_HEAT = 3
} stp_palette;

/* Which samples are left out because their back is turned to the eye. Every sample that is drawn is
 * lit on the side that is seen. */
typedef enum stp_cull {
    STP_CULL_AUTO =
        0, /* only backs proven hidden: in closed surfaces, seen from outside, unclipped */
    STP_CULL_NONE = 1, /* none */
    STP_CULL_BACK = 2  /* every back of known orientation, whether the surface is closed or not */
} stp_cull;

/* How the finest samples of a grid of heights or a depth image are drawn. */
typedef enum stp_grid_draw {
    STP_GRID_AUTO = 0,   /* as triangles where they lie some pixels apart, else as points */
    STP_GRID_POINTS = 1, /* as any other samples */
    STP_GRID_TRIANGLES = 2
} stp_grid_draw;

/* How the finest samples of an elevation map are drawn. */
typedef enum stp_maps_as {
    STP_MAPS_AUTO = 0, /* as a mesh where they lie some pixels apart, else as points */
    STP_MAPS_MESH = 1,
    STP_MAPS_SPLATS = 2, /* discs that show the plane through the three samples around each place */
    STP_MAPS_BLEND = 3,  /* discs, blended where they overlap: to compare with */
    STP_MAPS_PLAIN = 4,  /* discs, each in the colour of its sample: to compare with */
    STP_MAPS_POINTS = 5  /* as any other samples */
} stp_maps_as;

/* Whether what lies behind the surfaces of the last picture is left out. Such a picture is the
 * same, byte for byte, once the view is at rest or if it waits for blocks. */
typedef enum stp_occlusion_use {
    STP_OCCLUSION_AUTO = 0, /* on while streaming, unless little is hidden; else off */
    STP_OCCLUSION_ON = 1,
    STP_OCCLUSION_OFF = 2
} stp_occlusion_use;

/* A box outside which nothing is drawn: a sample is drawn if its centre lies in the box or on a
 * face. World coordinates; a side may be infinite. */
typedef struct stp_clip {
    bool enabled;
    stp_dbox box;
} stp_clip;

/* A plane of the host: a sample is drawn if its centre p has dot(normal, p) >= offset. normal: of
 * any length but 0; world coordinates. */
typedef struct stp_plane {
    stp_dvec3 normal;
    double offset;
} stp_plane;

#define STP_PLANES_LIMIT 6

/* What the error rule considers besides the error of the surface: bits of stp_draw_params.terms. A
 * term can only make levels finer, so errors stay within the threshold whatever is set. */
typedef enum stp_term {
    STP_TERM_RADIUS = 1,     /* limits projected radii: reconstruction is good only up to a cap */
    STP_TERM_COLOUR = 2,     /* limits the averaging of colours; only if colours are shown */
    STP_TERM_SILHOUETTE = 4, /* counts errors twice where outlines may be */
    STP_TERM_NONE = 8        /* only the error of the surface */
} stp_term;
/* The default leaves silhouettes out: at equal points, outlines gain less than surfaces lose. */
#define STP_TERMS_DEFAULT (STP_TERM_RADIUS | STP_TERM_COLOUR)

/* How a frame is drawn. Zero is the default of each member. */
typedef struct stp_draw_params {
    stp_lod lod;
    stp_reconstruct reconstruct;
    stp_shade shade;
    stp_colour colour;
    stp_palette palette;
    uint32_t hidden_models; /* bit i: model i is not drawn */
    double threshold_px;    /* greatest projected error; 0: 1 pixel */
    /* Greatest projected radius of a level that is not the finest. 0: STP_RADIUS_CAP_PX, or
     * STP_RADIUS_CAP_CHOSEN_PX. If the
     * threshold t is above 1 px, the cap is multiplied by t^2: a high threshold asks for fewer,
     * larger discs. */
    double radius_cap_px;
    uint32_t terms; /* bit set of stp_term; 0: STP_TERMS_DEFAULT */
    /* Values at the low and high end of the palette: intensity from 0 to 1, elevation as the
     * model's z. A viewer may start with the 2nd and 98th percentile: stp_model_colour_range. */
    double colour_range[2];
    /* For STP_SHADE_LEVEL, CHUNK, ERROR, CONFIDENCE and PRIMITIVE. 0: shows the overlay's colours
     * alone, unlit. Otherwise, up to 1: the share of the overlay mixed into the samples' colours,
     * lit as by PHONG. */
    double overlay;
    double edl; /* eye-dome lighting. 0: none; 1: what other viewers start with; more: darker */
    /* Direction towards the light, of any length, in world coordinates. 0 0 0: the light moves with
     * the camera. For LAMBERT and what is lit by PHONG. */
    double light[3];
    /* Lines of equal height (z), in the scan's units: at contour_base and every contour_step above
     * and below it. contour_step 0: none. */
    double contour_step, contour_base;
    /* Heights (z) are drawn so many times as high about exaggerate_about; 0: as they are, else 0.01
     * to 100. Cameras and matrices then belong to the world as drawn (stp_exaggerated); everything
     * else keeps the model's coordinates: clip box, planes, colour_range, contours, and what is
     * picked. The error on the screen stays within the threshold. */
    double exaggerate, exaggerate_about;
    /* While streaming, level changes fade instead of popping: the share of a change that one frame
     * still keeps from the frame before, in (0, 1). 0: no fading. Soon after the view comes to
     * rest, the picture is free of it. */
    double fade;
    stp_clip clip;
    /* What lies on the kept side of all of them, and in the clip box, is drawn: by every road and
     * reconstruction, and nothing else is picked. */
    stp_plane planes[STP_PLANES_LIMIT];
    unsigned plane_count;
    uint32_t hidden_classes[8]; /* bit c % 32 of word c / 32: samples of class c are not drawn. A
                                   merged sample has the class of one sample that it stands for */
    /* Silhouettes cover their pixels in part, as far as their discs reach, over what lies behind.
     * Not with POINTS, nor in a host's framebuffer. While streaming, only views at rest have them:
     * they take one more pass. Depths and picks stay the same. Zero is without, so alpha is 0 or 1:
     * set it if you blend the picture over another by its alpha. */
    bool smooth_edges;
    stp_cull cull;
    stp_occlusion_use occlusion; /* not with templates, SPLAT, POINTS, lines, triangles and grids */
    stp_grid_draw
        grid_draw; /* with SPLAT and POINTS grids and maps are drawn as any other samples */
    stp_maps_as maps_as;
    bool every_sample; /* as threshold zero: all level-0 samples, with any lod */
    bool stream;       /* never waits for blocks: draws what is above a missing block meanwhile */
    bool refine;       /* streaming, nothing changes: goes on past the threshold to every sample */
    bool keep_pixels;  /* also finishes level 0 of the pyramid: normals are read from it */
    bool timed;        /* waits for the GPU between stages, so that their times are true */
} stp_draw_params;

#define STP_RADIUS_CAP_PX 6.0
/* The same for models that draw chosen samples alone (stp_model_choose). */
#define STP_RADIUS_CAP_CHOSEN_PX 1.0
#define STP_EXAGGERATE_LEAST 0.01
#define STP_EXAGGERATE_MOST 100.0

/* Where an exaggerated picture has a place of the world, and the place that it has there. */
stp_dvec3 stp_exaggerated(const stp_draw_params *params, stp_dvec3 place);
stp_dvec3 stp_unexaggerated(const stp_draw_params *params, stp_dvec3 drawn);
/* A ball around all that an exaggerated picture shows of a ball: make the view with it. */
stp_ball stp_exaggerated_ball(const stp_draw_params *params, const stp_ball *ball);

/* The stages of a frame, in this order. */
typedef enum stp_stage {
    STP_STAGE_CHOOSE = 0,  /* levels, by a compute shader; otherwise PROJECT includes the choice */
    STP_STAGE_PROJECT = 1, /* finds the nearest sample of each pixel */
    STP_STAGE_RESOLVE = 2, /* turns these samples into pixels */
    STP_STAGE_BLEND = 3,   /* adds up splats */
    STP_STAGE_PULL = 4,
    STP_STAGE_PUSH = 5,    /* except to level 0 */
    STP_STAGE_FINISH = 6,  /* the push to level 0, and shading */
    STP_STAGE_EFFECTS = 7, /* eye-dome lighting, smooth edges, kept normals */
    STP_STAGE_COUNT
} stp_stage;

/* The stage's name: one word in lower case. */
const char *stp_stage_name(stp_stage stage);

typedef struct stp_draw_stats {
    /* Time to choose, to draw and to wait for the GPU, without loading chunks or compiling shaders.
     * stp_renderer_draw_into does not wait, so there this is the calling thread's time. */
    double frame_ms;
    double load_ms; /* time spent waiting for chunks; 0 while streaming */
    double project_ms, pull_push_ms, shade_ms; /* if timed; shading includes the last push */
    /* If timed: each stage from start to end by the GPU's own clock; 0 for a stage that did not
     * run. The clock of a software driver is the CPU's, and its stages also run on this thread. */
    double gpu_ms[STP_STAGE_COUNT];
    /* With GEOMETRY and COMPUTE, and with FULL on a software driver: samples drawn, without those
     * dropped as out of sight or culled; but all patches of one sample count. With splats and other
     * ways of choosing levels: samples sent to projection. 0 if the number is not known without
     * waiting. */
    uint64_t points_drawn;
    uint32_t chunks_drawn, chunks_missing; /* count blocks (docs/glossary.md) */
    uint32_t chunks_loading; /* on their way; 0 while some are missing: no room for them */
    /* Left out because the last picture hides them: patches of blocks that are drawn, and blocks.
     */
    uint64_t patches_hidden;
    uint32_t blocks_hidden;
    bool exposes; /* some of these may be in sight: the next frame of this view shows them */
    uint32_t passes;
    stp_lod lod; /* the one used: never AUTO */
    int pyramid_levels;
    bool cut_complete;
    bool more;         /* while streaming: the next frame may show more even if no chunk arrives */
    bool fading;       /* a level change still fades: the next frame shows less of it */
    bool every_sample; /* the picture holds the finest samples that the model's files have */
} stp_draw_stats;

/* Bytes used by a renderer, and bytes allotted to it. Only gpu_used changes. */
typedef struct stp_memory_use {
    uint64_t gpu_used, gpu_allotted, cpu_allotted;
} stp_memory_use;

/* The levels chosen for the last frame, recomputed on the CPU patch by patch. */
typedef struct stp_cut_measure {
    uint64_t points, patches;
    double max_error_px; /* greatest projected error chosen; unbounded patches are drawn finest */
} stp_cut_measure;

/* The 2nd and 98th percentile of intensity or elevation among the samples of the root chunk: a
 * start for colour_range. Errors: those of reading a chunk. */
stp_status stp_model_colour_range(const stp_model *model, stp_colour colour, double range[2],
                                  stp_error *err);

/* The shading meant for the model: UNLIT if `prep --shade unlit` made the file, else PHONG. */
stp_shade stp_model_shade(const stp_model *model);

/* ---- renderers ---- */

typedef struct stp_renderer stp_renderer;

typedef struct stp_renderer_params {
    const stp_model *model;    /* borrowed; must outlive the renderer */
    uint64_t gpu_memory_bytes; /* for samples and patches; 0: 1 GiB */
    uint64_t cpu_memory_bytes; /* for payloads, patches and chunks being decoded; 0: 1 GiB */
    unsigned thread_count;     /* for decoding; 0: one per processor */
    const char *shader_folder; /* a shader file here replaces the embedded one; may be NULL */
    /* Called from another thread as soon as a streaming frame would show more. Must not call the
     * renderer. */
    void (*wake)(void *);
    void *wake_context;
    /* The pictures are those of a flight: what the next view may show is kept from the first one
     * on. Otherwise from the second on, and blocks are decoded again for it. */
    bool views_follow;
} stp_renderer_params;

/* Errors: GL (no current 4.5 context), LIMIT (budget too small), NOT_FOUND (shader_folder),
 * OUT_OF_MEMORY, and those of reading the root chunk. */
stp_status stp_renderer_create(stp_renderer **out, const stp_renderer_params *params,
                               stp_error *err);
void stp_renderer_destroy(stp_renderer **renderer);

/* Replaces the models that are drawn; all appear in one picture. The models are borrowed and must
 * outlive the renderer. Loads their root chunks anew. On failure the renderer keeps drawing the
 * models it had. If their roots cannot be read again either, the error is IO, and drawing fails
 * until a call of stp_renderer_set_models succeeds. Errors: those of stp_renderer_create;
 * INVALID_ARGUMENT (no model, or more than 32). */
stp_status stp_renderer_set_models(stp_renderer *renderer, const stp_model *const *models,
                                   size_t count, stp_error *err);

/* Draws the renderer's own picture, in the size of the view. stats may be NULL. A damaged chunk is
 * not an error: its parent is drawn instead, and stp_renderer_damage reports the damage. Shader
 * programs are compiled for params, and again if the last frame's programs do not fit them. Errors:
 * GL (a shader), IO, LIMIT, OUT_OF_MEMORY; INVALID_ARGUMENT (clip box inverted or not a number; a
 * plane without a direction or not finite, or more than STP_PLANES_LIMIT;
 * overlay, contours, exaggerate, light, edl or fade out of range). */
stp_status stp_renderer_draw(stp_renderer *renderer, const stp_view *view,
                             const stp_draw_params *params, stp_draw_stats *stats, stp_error *err);

/* How a picture lands in the host's framebuffer. Zero is the default. */
typedef struct stp_target {
    /* Set this if the host's framebuffer holds light, as floating-point framebuffers of lit scenes
     * do: the picture's colours, which are encoded for screens (sRGB), are then decoded. Otherwise
     * colours are written as they are, without GL_FRAMEBUFFER_SRGB. */
    bool linear_light;
} stp_target;

/* Draws as stp_renderer_draw does, then copies the picture into the host's framebuffer like one
 * draw call of the host. The copy goes into the framebuffer bound for drawing, within viewport 0.
 * The host's scissor, stencil test, depth test and function, depth mask, colour mask, depth range
 * and clip control apply. Only covered pixels are written, each with its own depth, so points hide
 * the host's triangles and are hidden by them, whichever is drawn first. Enable GL_DEPTH_TEST, and
 * draw before anything that blends.
 *
 * view: from stp_view_from_matrices, in the viewport's size. Whatever lies outside the projection's
 * depth range is cut away unless GL_DEPTH_CLAMP is on. target and stats may be NULL.
 * Colour goes to the first draw buffer, alpha is 1, nothing is blended. In a multisampled
 * framebuffer all samples of a pixel get the same colour and depth.
 * The call does not wait for the GPU. With params->stream it does not wait for chunks either, and
 * draws what is resident; if stats->cut_complete is false or stats->more is true, draw again.
 * Errors: those of stp_renderer_draw; INVALID_ARGUMENT (view or viewport), UNSUPPORTED (framebuffer
 * incomplete, or of integers). On error the host's framebuffer is untouched. */
stp_status stp_renderer_draw_into(stp_renderer *renderer, const stp_view *view,
                                  const stp_draw_params *params, const stp_target *target,
                                  stp_draw_stats *stats, stp_error *err);

/* Reads the last picture: width * height * 4 bytes RGBA, bottom row first. Alpha is 255 where
 * covered and less at smooth edges; there colours are premultiplied by alpha. */
stp_status stp_renderer_read(stp_renderer *renderer, uint8_t *rgba, stp_error *err);

/* The last picture's depth at a pixel (bottom row first), along the camera's axis; 0 if the pixel
 * is empty. Errors: INVALID_ARGUMENT (outside the picture), GL. */
stp_status stp_renderer_depth_at(stp_renderer *renderer, int x, int y, float *depth,
                                 stp_error *err);

#define STP_PICK_NO_CHUNK UINT32_MAX

/* What a picture shows at a pixel. */
typedef struct stp_pick {
    bool hit; /* false: the pixel is empty, and the other members mean nothing */
    /* Where the ray through the pixel's centre meets the surface, but no farther than `radius` from
     * the centre of the nearest sample drawn: at outlines a little beside the ray. */
    stp_dvec3 position;
    double depth, depth_end; /* the interval of the front surface along the camera's axis */
    stp_dvec3 normal;        /* of the surface, unit, world axes; turned to the eye if two-sided */
    /* If the picture is exaggerated, position, normal and radius are those of the model; depths are
     * always the picture's. */
    uint8_t rgb[3];    /* of the surface, unlit, after `colour` and `overlay` */
    bool interpolated; /* no sample fell on this pixel, or only one behind the front surface */
    int pyramid_level; /* the level that the pixel comes from; 0: measured */
    /* The nearest sample drawn. chunk is STP_PICK_NO_CHUNK, and only `radius` is known, if the
     * picture was made in several passes or the sample's chunk has been evicted since. */
    double radius; /* world units */
    uint32_t chunk;
    int level; /* of its patch, 0 the finest; -1: not known */
    uint8_t class_id;
    double intensity; /* 0 to 1 */
} stp_pick;

/* Picks the front surface of the last picture at a pixel (bottom row first), never a surface behind
 * it. If the pixel is empty, picks the nearest covered pixel up to two pixels away, so outlines and
 * pinholes can be picked. Leaves the picture as it is. But if refine (or a small budget) is making
 * a still picture in passes, redraws the frame before it, and the passes start again.
 * Errors: INVALID_ARGUMENT (outside the picture), GL, OUT_OF_MEMORY. */
stp_status stp_renderer_pick(stp_renderer *renderer, int x, int y, stp_pick *out, stp_error *err);
/* Reads the depths of the last picture: width * height floats, bottom row first, as from
 * stp_renderer_depth_at. Errors: LIMIT (2 GiB of depths), GL. */
stp_status stp_renderer_read_depth(stp_renderer *renderer, float *depth, stp_error *err);

/* Reads the normals of the last picture, which must have been drawn with keep_pixels: three floats
 * a pixel (width * height * 3), bottom row first. Unit vectors in world axes, turned to the viewer
 * where both sides are drawn; the model's own, even if exaggerated; 0 0 0 where empty. Errors:
 * INVALID_ARGUMENT (drawn without keep_pixels), OUT_OF_MEMORY, GL. */
stp_status stp_renderer_read_normals(stp_renderer *renderer, float *xyz, stp_error *err);

/* Copies the last picture to the lower left corner of a framebuffer (0: the window's), as width x
 * height pixels. A picture of another size is stretched. */
void stp_renderer_present(stp_renderer *renderer, unsigned framebuffer, int width, int height);
/* The same, but of these width x height pixels only the columns from `begin` on and before `end`:
 * so a framebuffer shows pictures of several renderers side by side. 0 <= begin <= end. */
void stp_renderer_present_columns(stp_renderer *renderer, unsigned framebuffer, int width,
                                  int height, int begin, int end);

/* Recomputes the levels chosen for the last frame. Not for STP_LOD_FULL with several passes. */
void stp_renderer_measure(const stp_renderer *renderer, stp_cut_measure *out);

/* Compiles the shaders again (from the folder, if one was given). On failure the old ones stay in
 * use. Errors: GL. */
stp_status stp_renderer_reload_shaders(stp_renderer *renderer, stp_error *err);

/* A sentence about the first damage found while reading chunks, and how many more were found; empty
 * if there is none. */
const char *stp_renderer_damage(const stp_renderer *renderer);
/* A sentence about why missing chunks do not arrive at the moment; empty if they do. */
const char *stp_renderer_trouble(const stp_renderer *renderer);
uint64_t stp_renderer_bytes_read(const stp_renderer *renderer);
stp_memory_use stp_renderer_memory(const stp_renderer *renderer);
/* Bytes of stp_memory_use.gpu_used that the last frame needs. The rest, other blocks and levels for
 * nearer views, is given back where there is no room for something else. Looks at all patches. */
uint64_t stp_renderer_gpu_pinned(const stp_renderer *renderer);
/* Whether a streaming frame would now show something that the last frame lacked. */
bool stp_renderer_has_news(const stp_renderer *renderer);

#ifdef __cplusplus
}
#endif

#endif
