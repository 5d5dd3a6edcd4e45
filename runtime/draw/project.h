/* Projection: draws the samples of a cut, so that each pixel keeps its nearest; on four roads.
 * Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_PROJECT_H
#define STP_RUNTIME_DRAW_PROJECT_H

#include "runtime/cut/model.h"
#include "runtime/cut/sight.h"
#include "runtime/draw/pyramid.h"
#include "runtime/draw/scatter.h"
#include "runtime/draw/splat.h"
#include "runtime/draw/squares.h"
#include "runtime/draw/stage_clock.h"
#include "runtime/gl/shader.h"
#include "runtime/stipple.h"

#include <stddef.h>

typedef struct stp_project {
    GLuint patch_program, sample_program, vertex_program; /* the last: of patch vertices */
    GLuint strip_program, wide_program, triangle_program;
    stp_runs runs;
    stp_scatter scatter;
    stp_squares squares;
    stp_splat splat; /* used instead of the programs for samples if splats are drawn */
    GLuint index_buffer;
    uint32_t *indices; /* names of samples, for the roads that choose on the CPU */
    size_t index_count, index_capacity;
} stp_project;

/* Compiles the programs of a road, if they are not there yet. A project begins as zero and keeps
 * its variant. folder: shader files here replace the embedded ones; may be NULL. Errors: GL. */
stp_status stp_project_prepare(stp_project *project, const stp_variant *variant, stp_lod lod,
                               const char *folder, stp_error *err);
/* Compiles the programs that draw squares of grids and maps, in the same way. Errors: GL. */
stp_status stp_project_prepare_squares(stp_project *project, const stp_variant *variant,
                                       const char *folder, stp_error *err);
void stp_project_destroy(stp_project *project);

/* The input of every road. */
struct stp_project_params {
    const stp_scene *scene;
    const stp_block_cache *cache;
    const stp_gpu_frame *frame;
    stp_dvec3 eye;
    const stp_draw *draws; /* of resident blocks */
    size_t draw_count;
    const stp_sight *sight; /* of the draws */
    stp_lod lod;
    const stp_pyramid *pyramid; /* drawn into; its nearest_frame is bound */
    const stp_tiles *tiles;     /* of the picture */
    bool first;                 /* the first pass of the picture */
    bool keeps;                 /* view, draws and sight are those of the last picture */
    bool waits;                 /* may wait for the GPU, since the frame waits at its end anyway */
    stp_stage_clock *clock;     /* if the frame is timed, else NULL */
};

/* Draws the samples of resident blocks into the bound framebuffer, in order, by the road prepared.
 * Patch vertices listed in STP_SIGHT_VERTICES come first (shaders/README.md, "Projection", says why
 * this changes no picture). Adds to *points the number of samples sent. If the geometry shader
 * chooses, adds nothing: a query counts. If compute shaders choose, adds the listed patch vertices;
 * stp_runs_count_drawn counts the rest. Errors: OUT_OF_MEMORY; with STP_LOD_COMPUTE also GL,
 * LIMIT. */
stp_status stp_project_draw(stp_project *project, const stp_project_params *params,
                            uint64_t *points, stp_error *err);
/* Draws strips and triangles, if the chosen level is drawn as such. Geometry shaders choose their
 * levels on every road. Call after drawing samples; with splats, after drawing their fronts. */
void stp_project_draw_shapes(stp_project *project, const stp_project_params *params);
/* Draws squares of grids and maps; adds their samples to *points. Call after the shapes. Errors:
 * OUT_OF_MEMORY, LIMIT (more squares than names tell apart), GL. */
stp_status stp_project_draw_squares(stp_project *project, const stp_project_params *params,
                                    uint64_t *points, stp_error *err);
/* As stp_project_draw for splats: lists the splats, and project->splat draws them later. With
 * STP_LOD_GEOMETRY, levels are chosen as with STP_LOD_COMPUTE. */
stp_status stp_project_list(stp_project *project, const stp_project_params *params,
                            uint64_t *points, stp_error *err);

#endif
