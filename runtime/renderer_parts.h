/* The members of a renderer. Only the files that draw its pictures include this header: renderer.c,
 * frame*.c, occlude.c, settle.c and draw/readback.c. Threads: the render thread. */
#ifndef STP_RUNTIME_RENDERER_PARTS_H
#define STP_RUNTIME_RENDERER_PARTS_H

#include "runtime/cut/cut.h"
#include "runtime/cut/scene.h"
#include "runtime/cut/sight.h"
#include "runtime/cut/tiles.h"
#include "runtime/draw/draw_params.h"
#include "runtime/draw/fade.h"
#include "runtime/draw/pixel_blocks.h"
#include "runtime/draw/project.h"
#include "runtime/draw/reconstruct.h"
#include "runtime/draw/road.h"
#include "runtime/draw/stage_clock.h"
#include "runtime/gl/shader.h"
#include "runtime/occlude.h"
#include "runtime/settle.h"
#include "runtime/stipple.h"
#include "runtime/stream/cache/block_cache.h"
#include "runtime/stream/motion.h"

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
    /* States of the cache (stp_block_cache_state), or 0: with which the cut was chosen, complete;
     * and with which its sight was looked at, too, all draws at once. */
    uint64_t chosen_state, looked_state;
    bool keeps; /* the cut, its sight and its records are taken from the last frame */
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

#endif
