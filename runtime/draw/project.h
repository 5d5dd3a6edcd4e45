/* Projection: the samples of a cut to the nearest sample of each pixel, by four roads.
 * Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_PROJECT_H
#define STP_RUNTIME_DRAW_PROJECT_H

#include "runtime/cut/model.h"
#include "runtime/cut/sight.h"
#include "runtime/draw/pyramid.h"
#include "runtime/draw/scatter.h"
#include "runtime/draw/splat.h"
#include "runtime/draw/stage_clock.h"
#include "runtime/gl/shader.h"
#include "runtime/stipple.h"

#include <stddef.h>

typedef struct stp_project {
    GLuint patch_program, sample_program;
    GLuint strip_program, wide_program, triangle_program;
    stp_runs runs;
    stp_scatter scatter;
    stp_splat splat; /* instead of the programs for samples, where splats are drawn */
    GLuint index_buffer;
    uint32_t *indices; /* of samples, of the roads that choose on the CPU */
    size_t index_count, index_capacity;
    stp_range *spans; /* of one chunk's samples, for STP_LOD_FULL */
    size_t span_count, span_capacity;
} stp_project;

/* Compiles the programs of a road where they are not there; a project begins as zero, and keeps to
 * its variant. folder: shader files that win over the embedded ones, or NULL. Errors: GL. */
stp_status stp_project_prepare(stp_project *project, const stp_variant *variant, stp_lod lod,
                               const char *folder, stp_error *err);
void stp_project_destroy(stp_project *project);

/* What any road projects. */
struct stp_project_params {
    const stp_scene *scene;
    const stp_chunk_cache *cache;
    const stp_gpu_frame *frame;
    stp_dvec3 eye;
    const stp_draw *draws; /* of resident chunks */
    size_t draw_count;
    const stp_sight *sight; /* the draws' */
    stp_lod lod;
    const stp_pyramid *pyramid; /* what is drawn into; its nearest_frame is bound */
    bool first;                 /* pass over the picture */
    bool waits;                 /* for the GPU: the frame does so at its end in any case */
    stp_stage_clock *clock;     /* of a frame that is timed, or NULL */
};

/* Draws the samples of resident chunks into the bound framebuffer, in order, by the road prepared:
 * first the vertices that were listed apart, if any (shaders/README.md, Projection: why that
 * changes no picture). Adds to *points what was sent. Where the geometry shader chooses it adds
 * nothing, and a query counts; where compute shaders do, it adds the vertices listed apart, and
 * stp_runs_count_drawn tells the rest. Errors: OUT_OF_MEMORY; with STP_LOD_COMPUTE also GL, LIMIT.
 */
stp_status stp_project_draw(stp_project *project, const stp_project_params *params,
                            uint64_t *points, stp_error *err);
/* Draws strips and triangles there, where levels of them are chosen that are drawn as such;
 * geometry shaders choose, whatever the road. After the samples, but with splats after their
 * fronts. */
void stp_project_draw_shapes(stp_project *project, const stp_project_params *params);
/* The same as drawing, for splats: lists them, after which project->splat draws them. With
 * STP_LOD_GEOMETRY levels are chosen as with STP_LOD_COMPUTE. */
stp_status stp_project_list(stp_project *project, const stp_project_params *params,
                            uint64_t *points, stp_error *err);

#endif
