/* The members of a renderer, and the functions that renderer.c, frame.c, frame_load.c,
 * frame_pass.c, settle.c and draw/readback.c share. Only these files include this header. */
#ifndef STP_RUNTIME_RENDERER_PARTS_H
#define STP_RUNTIME_RENDERER_PARTS_H

#include "runtime/cut/cut.h"
#include "runtime/cut/scene.h"
#include "runtime/cut/sight.h"
#include "runtime/cut/tiles.h"
#include "runtime/draw/draw_params.h"
#include "runtime/draw/fade.h"
#include "runtime/draw/far_depths.h"
#include "runtime/draw/pixel_blocks.h"
#include "runtime/draw/project.h"
#include "runtime/draw/reconstruct.h"
#include "runtime/draw/road.h"
#include "runtime/draw/stage_clock.h"
#include "runtime/gl/shader.h"
#include "runtime/stipple.h"
#include "runtime/stream/cache/block_cache.h"
#include "runtime/stream/motion.h"

typedef enum stp_settle_phase {
    STP_SETTLE_NONE,
    STP_SETTLE_RUNS,
    STP_SETTLE_DONE,
    STP_SETTLE_FAILED /* a block does not fit in GPU memory: frames are drawn as before */
} stp_settle_phase;

/* A still picture that settle.c draws pass by pass, while the last picture is shown. Zero: none. */
typedef struct stp_settling {
    stp_settle_phase phase;
    stp_draw_params params; /* for the passes */
    bool loading;           /* the blocks of a pass are on their way */
    bool headers;           /* as far as they tell the levels of patches */
    size_t begin;           /* the cut's first draw that is not drawn yet */
    bool fronts_done;       /* splats: the fronts of all draws are drawn */
    stp_cache_load load;
    double radius_px; /* greatest of the passes so far */
    stp_draw_stats stats;
} stp_settling;

/* What pictures hide (occlude.c). Zero: nothing is known. */
typedef struct stp_occluding {
    stp_far_depths depths;
    stp_occlusion maps[2]; /* what the last pictures hide */
    int newest;
    bool known;                /* maps[newest] is of a picture like this one */
    bool coarse;               /* the last picture lacked many blocks */
    bool on;                   /* for this picture */
    bool squares;              /* some squares of grids were drawn */
    const stp_occlusion *used; /* what this picture leaves out; NULL: nothing */
    int rounds;                /* pictures of this view that brought something to light */
    uint64_t shown;            /* patches of this picture that were not left out */
    int guesses;               /* pictures that this frame drew to guess what is hidden */
    int idle;                  /* so many pictures go without */
} stp_occluding;

struct stp_renderer {
    stp_renderer_params params;
    stp_scene scene;
    stp_pool *pool;
    stp_block_cache *cache;
    stp_project project;
    stp_reconstruct_programs reconstruct;
    stp_pyramid pyramid;
    stp_tiles tiles;
    stp_pixel_blocks blocks;
    stp_sight sight;
    GLuint frame_buffer; /* uniform block */
    GLuint points_query;
    stp_stage_clock clock; /* for frames that are timed */
    GLuint composite;      /* program; 0 until something is drawn into a host's framebuffer */
    stp_cut cut, ahead_cut;
    stp_motion motion;
    stp_road road;         /* picks the road if the host asks for STP_LOD_AUTO */
    bool road_chosen;      /* the last picture was drawn by the road that `road` picked */
    bool moves;            /* the camera moved since the last frame */
    stp_draw_params drawn; /* of the last frame */
    stp_draw_stats last;   /* of the last frame */
    bool still;            /* view and parameters are the same as in the last frame */
    uint64_t drawn_stamp;  /* of the last cut drawn */
    stp_settling settling;
    stp_fade fade;
    stp_occluding occluding;
    stp_gpu_chunk *chunk_records; /* by slot */
    stp_want *wants;
    size_t want_capacity;
    uint64_t stamp; /* counts passes, for the cache */
    char *shader_folder;
    stp_variant variant; /* the programs are compiled for this */
    stp_gpu_frame frame; /* of the last picture */
    stp_dvec3 eye;
    const GLuint *kept; /* finished pixels of the last picture if keep_pixels is set, else NULL */
};

/* Splats are drawn in two parts: the first finds the front of each pixel, the second adds up the
 * splats at the front. If the cut takes several passes, all passes of the first part run before the
 * second part begins. */
typedef enum stp_splat_part {
    STP_SPLAT_BOTH = 0,
    STP_SPLAT_FRONTS,
    STP_SPLAT_BLENDS
} stp_splat_part;

/* A picture while it is being drawn. */
typedef struct stp_drawing {
    const stp_view *view;
    const stp_draw_params *params;
    stp_draw_stats stats;
    bool waits;  /* waits for the GPU at the end */
    bool counts; /* counts by a query how many points the geometry shader emits */
    stp_splat_part part;
    bool ready;      /* stp_frame_ready is done */
    bool compiled;   /* and compiled programs */
    double ready_ms; /* what it took, unless blocks were on their way meanwhile */
} stp_drawing;

/* Compiles the programs for the picture, unless the last one's fit, and makes room for its pixels.
 * A picture first asks for blocks, then does this, since the former takes time of the network, the
 * latter of the processor. Does nothing the second time. Errors: GL, OUT_OF_MEMORY. */
stp_status stp_frame_ready(stp_renderer *r, stp_drawing *d, stp_error *err);

/* Compiles the programs of a variant, and of one road of projection, in place of the old ones.
 * Errors: GL, OUT_OF_MEMORY, NOT_FOUND. */
stp_status stp_frame_compile(stp_renderer *r, const stp_variant *variant, stp_lod lod,
                             stp_error *err);
/* Compiles the programs for `lod`, if the renderer does not have them: a picture may take another
 * road than its parameters say. Errors: GL. */
stp_status stp_frame_prepare(stp_renderer *r, stp_lod lod, stp_error *err);
/* The same for programs that the renderer does not own yet. */
stp_status stp_frame_prepare_road(stp_project *project, stp_reconstruct_programs *reconstruct,
                                  const char *folder, const stp_variant *variant, stp_lod lod,
                                  stp_error *err);
/* Fills the frame record that shaders and the cut read: view, threshold, colours, and what the
 * picture leaves out. */
stp_gpu_frame stp_frame_describe(const stp_view *view, const stp_draw_params *params,
                                 const stp_scene *scene);
/* Chooses the cut of the frame; the sight has looked at none of its draws yet. While chunks stream
 * and the camera moves, the choice depends on the last cut. Errors: OUT_OF_MEMORY. */
stp_status stp_frame_select(stp_renderer *r, const stp_drawing *d, stp_error *err);
/* Projects resident draws, then resolves the nearest sample of each pixel. Errors: GL, LIMIT,
 * OUT_OF_MEMORY. */
stp_status stp_frame_pass(stp_renderer *r, stp_drawing *d, const stp_draw *draws, size_t count,
                          stp_error *err);
/* Which part of splats a pass draws: a pass of `count` blocks from the cut's draw `begin` on. */
stp_splat_part stp_frame_part(const stp_renderer *r, bool fronts_done, size_t begin, size_t count);
/* The parameters for looking at the sight (stp_sight_look). */
stp_sight_params stp_frame_sight(const stp_renderer *r);
/* Makes the picture from what the passes left: pulls, pushes and shades. Errors: OUT_OF_MEMORY. */
stp_status stp_frame_finish(stp_renderer *r, stp_drawing *d, double radius_px, stp_error *err);
/* Lists the blocks and levels that draws want in r->wants. headers: no finer than what tells the
 * levels of their patches. Errors: OUT_OF_MEMORY. */
stp_status stp_frame_list_wants(stp_renderer *r, const stp_draw *draws, size_t count, bool headers,
                                stp_error *err);
/* Whether a picture that waits loads headers first: unless it shows every sample. */
bool stp_frame_asks_headers(const stp_renderer *r);
/* Sets the levels of draws whose headers are resident to what their patches need. */
stp_status stp_frame_refine(stp_renderer *r, stp_draw *draws, size_t count, stp_error *err);
/* Loads the cut's draws from draw `begin` on, as many as there is room for, and waits. known: their
 * levels are those that their patches need. Errors: IO, GL, OUT_OF_MEMORY. */
stp_status stp_frame_load_draws(stp_renderer *r, stp_drawing *d, size_t begin, bool known,
                                stp_cache_load *load, stp_error *err);
/* Chooses the cut and loads what its patches ask for, tier by tier, and waits. *complete: all of it
 * is there. Errors: as stp_frame_load_draws. */
stp_status stp_frame_load_asked(stp_renderer *r, stp_drawing *d, bool *complete, stp_error *err);
/* Marks what the cut draws, or falls back on, as used. */
void stp_frame_touch(stp_renderer *r);
/* Requests the blocks that are missing, and those that the camera's motion will reveal. ahead: may
 * be NULL. Errors: OUT_OF_MEMORY. */
stp_status stp_frame_want_missing(stp_renderer *r, const stp_drawing *d, const stp_view *ahead,
                                  stp_error *err);
/* Binds what all passes read. Call this in the state that stp_gl_state_enter sets. */
void stp_renderer_bind_frame(const stp_renderer *r);

/* Uploads r->frame for the shaders. */
void stp_frame_upload(const stp_renderer *r);
/* Draws one frame's picture. Errors: IO, GL, LIMIT, OUT_OF_MEMORY. */
stp_status stp_frame_draw(stp_renderer *r, stp_drawing *d, const stp_view *ahead, stp_error *err);

/* Begins a frame: chooses what its picture leaves out as hidden. Errors: OUT_OF_MEMORY. */
stp_status stp_occlude_begin(stp_renderer *r, const stp_draw_params *params, stp_error *err);
/* Chooses what the next picture leaves out by what is known now. streams: of a picture that does
 * not wait. */
void stp_occlude_choose(stp_renderer *r, bool streams);
/* Whether a picture of what is resident is worth its time: many blocks are missing that it may
 * hide. */
bool stp_occlude_wants_guess(stp_renderer *r);
/* Takes what such a picture hides. Errors: OUT_OF_MEMORY, GL. */
stp_status stp_occlude_guessed(stp_renderer *r, stp_error *err);
/* Begins to look at what the picture hides, once it is finished. Errors: GL. */
stp_status stp_occlude_look(stp_renderer *r, int levels, stp_error *err);
/* Ends a picture: counts what was left out, and finds out whether it came to light. Errors:
 * OUT_OF_MEMORY, GL. */
stp_status stp_occlude_end(stp_renderer *r, stp_drawing *d, stp_error *err);
/* What the picture leaves out of what is resident; NULL: nothing. */
const stp_occlusion *stp_occlude_drawn(const stp_renderer *r);
/* Counts what a pass leaves out, of so many draws just looked at. */
void stp_occlude_count(stp_renderer *r, stp_drawing *d, size_t draw_count);
/* The next pictures leave nothing out, until a frame begins. */
void stp_occlude_pause(stp_renderer *r);
/* Forgets what pictures hide. */
void stp_occlude_forget(stp_renderer *r);
void stp_occlude_destroy(stp_renderer *r);

/* Whether to begin or continue a settling picture, instead of drawing a frame. */
bool stp_settle_wanted(const stp_renderer *r, const stp_drawing *d);
/* Whether the next frame continues the settling picture if nothing changes and no chunk arrives. */
bool stp_settle_goes_on(const stp_renderer *r, const stp_drawing *d);
/* Takes one step of a settling picture, without waiting for chunks. Errors: GL, OUT_OF_MEMORY. */
stp_status stp_settle_step(stp_renderer *r, stp_drawing *d, stp_error *err);

#endif
