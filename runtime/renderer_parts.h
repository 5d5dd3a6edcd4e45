/* What a renderer is made of: for renderer.c, frame.c and settle.c alone. */
#ifndef STP_RUNTIME_RENDERER_PARTS_H
#define STP_RUNTIME_RENDERER_PARTS_H

#include "runtime/cut/cut.h"
#include "runtime/cut/scene.h"
#include "runtime/cut/sight.h"
#include "runtime/cut/tiles.h"
#include "runtime/draw/blocks.h"
#include "runtime/draw/fade.h"
#include "runtime/draw/project.h"
#include "runtime/draw/reconstruct.h"
#include "runtime/draw/road.h"
#include "runtime/draw/stage_clock.h"
#include "runtime/gl/shader.h"
#include "runtime/stipple.h"
#include "runtime/stream/chunk_cache.h"
#include "runtime/stream/motion.h"

typedef enum stp_settle_phase {
    STP_SETTLE_NONE,
    STP_SETTLE_RUNS,
    STP_SETTLE_DONE,
    STP_SETTLE_FAILED /* a chunk fits nowhere: frames go on as before */
} stp_settle_phase;

/* A still picture in the making: pass by pass, while the last picture is shown. Zero is none. */
typedef struct stp_settling {
    stp_settle_phase phase;
    stp_draw_params params; /* of its passes */
    bool loading;           /* a pass's chunks are on their way */
    size_t begin;           /* draws before it are drawn */
    bool fronts_done;       /* of splats, of all draws */
    stp_cache_load load;
    double radius_px; /* greatest so far */
    stp_draw_stats stats;
} stp_settling;

struct stp_renderer {
    stp_renderer_params params;
    stp_scene scene;
    stp_pool *pool;
    stp_chunk_cache *cache;
    stp_project project;
    stp_reconstruct_programs reconstruct;
    stp_pyramid pyramid;
    stp_tiles tiles;
    stp_blocks blocks;
    stp_sight sight;
    GLuint frame_buffer; /* uniform block */
    GLuint points_query;
    stp_stage_clock clock; /* for frames that are timed */
    GLuint composite;      /* program, once something was drawn into a host's framebuffer */
    stp_cut cut, ahead_cut;
    stp_motion motion;
    stp_road road;         /* where none is asked for */
    bool moves;            /* the camera, since the last frame */
    stp_draw_params drawn; /* of the last frame */
    stp_draw_stats last;   /* of the last frame */
    bool still;            /* view and parameters are those of the last frame */
    uint64_t drawn_stamp;  /* of the last cut that was drawn */
    stp_settling settling;
    stp_fade fade;
    stp_gpu_chunk *chunk_records; /* by slot */
    stp_want *wants;
    size_t want_capacity;
    uint64_t stamp; /* counts passes, for the cache */
    char *shader_folder;
    stp_variant variant; /* what the programs are compiled for */
    stp_gpu_frame frame; /* of the last picture */
    stp_dvec3 eye;
    const GLuint *kept; /* likewise: its finished pixels where keep_pixels asked for them */
};

/* Splats are drawn twice: which are in front, then what they add up to. In several passes over the
 * cut the first is done with all of it before the second begins. */
typedef enum stp_splat_part {
    STP_SPLAT_BOTH = 0,
    STP_SPLAT_FRONTS,
    STP_SPLAT_BLENDS
} stp_splat_part;

/* One picture in the making. */
typedef struct stp_drawing {
    const stp_view *view;
    const stp_draw_params *params;
    stp_draw_stats stats;
    bool waits;  /* for the GPU, at the end */
    bool counts; /* what the geometry shader emits, by a query */
    stp_splat_part part;
} stp_drawing;

/* Compiles what a road needs, where a picture takes another than its parameters say. Errors: GL. */
stp_status stp_frame_prepare(stp_renderer *r, stp_lod lod, stp_error *err);
/* The same for programs that are not the renderer's yet. */
stp_status stp_frame_prepare_road(stp_project *project, stp_reconstruct_programs *reconstruct,
                                  const char *folder, const stp_variant *variant, stp_lod lod,
                                  stp_error *err);
/* What shaders and the cut read of a picture: of its view, its threshold, its colours and what it
 * leaves out. */
stp_gpu_frame stp_frame_describe(const stp_view *view, const stp_draw_params *params,
                                 const stp_scene *scene);
/* Chooses the frame's cut, of which nothing is looked at yet; while chunks stream and the camera
 * moves it depends on the last one. Errors: OUT_OF_MEMORY. */
stp_status stp_frame_select(stp_renderer *r, const stp_drawing *d, stp_error *err);
/* Projects resident draws and resolves what they left nearest. Errors: GL, LIMIT, OUT_OF_MEMORY. */
stp_status stp_frame_pass(stp_renderer *r, stp_drawing *d, const stp_draw *draws, size_t count,
                          stp_error *err);
/* What of splats is drawn in a pass of `count` chunks, from the cut's draw `begin` on. */
stp_splat_part stp_frame_part(const stp_renderer *r, bool fronts_done, size_t begin, size_t count);
/* What the sight is looked at with. */
stp_sight_params stp_frame_sight(const stp_renderer *r);
/* Pulls, pushes and shades what the passes left: the picture. Errors: OUT_OF_MEMORY. */
stp_status stp_frame_finish(stp_renderer *r, stp_drawing *d, double radius_px, stp_error *err);
/* The wants of draws, in r->wants. Errors: OUT_OF_MEMORY. */
stp_status stp_frame_list_wants(stp_renderer *r, const stp_draw *draws, size_t count,
                                stp_error *err);
/* Binds what all passes read; the state they are drawn in is that of stp_gl_state_enter. */
void stp_renderer_bind_frame(const stp_renderer *r);

/* What shaders read of r->frame. */
void stp_frame_upload(const stp_renderer *r);
/* Draws a frame: the picture. Errors: IO, GL, LIMIT, OUT_OF_MEMORY. */
stp_status stp_frame_draw(stp_renderer *r, stp_drawing *d, const stp_view *ahead, stp_error *err);

/* Whether a picture that settles is to be begun or gone on with, instead of a frame's own. */
bool stp_settle_wanted(const stp_renderer *r, const stp_drawing *d);
/* Whether the next frame, if nothing changes, goes on with it without any chunk coming. */
bool stp_settle_goes_on(const stp_renderer *r, const stp_drawing *d);
/* One step of it, without waiting. Errors: GL, OUT_OF_MEMORY. */
stp_status stp_settle_step(stp_renderer *r, stp_drawing *d, stp_error *err);

#endif
