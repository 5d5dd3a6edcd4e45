/* Projection: the samples of a cut to the nearest sample of each pixel, by four roads.
 * Threads: the render thread. */
#ifndef STP_RUNTIME_PROJECT_H
#define STP_RUNTIME_PROJECT_H

#include "runtime/model.h"
#include "runtime/pyramid.h"
#include "runtime/scatter.h"
#include "runtime/shader.h"
#include "runtime/sight.h"
#include "runtime/stipple.h"

#include <stddef.h>

/* Shader files of the roads that rasterise: what a sample becomes. */
typedef struct stp_project_files {
    const char *sample, *patch, *fragment; /* vertex shader; geometry shader; fragment shader */
    const char *shape;   /* fragment shader of segments and triangles; NULL: they are not drawn */
    bool parts_vertices; /* the vertex shader is told of vertices that are listed apart */
} stp_project_files;

/* A pixel; a splat in the visibility pass, and in the attribute pass. */
extern const stp_project_files stp_project_pixels, stp_project_splat_fronts,
    stp_project_splat_blends;

typedef struct stp_project {
    const stp_project_files *files;
    GLuint patch_program, sample_program, strip_program, triangle_program;
    stp_scatter scatter;
    GLuint index_buffer;
    uint32_t *indices; /* of samples, for STP_LOD_CPU */
    size_t index_count, index_capacity;
    stp_range *runs; /* of one chunk's samples, for STP_LOD_FULL */
    size_t run_count, run_capacity;
} stp_project;

/* Compiles the programs of a road where they are not there; a project begins as zero, and keeps to
 * its files. Splats have no compute shaders, nor have segments and triangles. folder: shader files
 * that win over the embedded ones, or NULL; variant: the same for all roads. Errors: GL. */
stp_status stp_project_prepare(stp_project *project, const stp_project_files *files, stp_lod lod,
                               const char *folder, const stp_variant *variant, stp_error *err);
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
};

/* Draws resident chunks into the bound framebuffer, in order, by the road prepared: first the
 * vertices that were listed apart, if any (shaders/README.md, Projection: why that changes no
 * picture), last segments and triangles, which geometry shaders choose whatever the road. Adds to
 * *points what was sent (where the geometry shader chooses: the samples of the patches it looked at
 * are not known here, and a query counts what it emitted). Errors: OUT_OF_MEMORY; with
 * STP_LOD_COMPUTE also GL, LIMIT. */
stp_status stp_project_draw(stp_project *project, const stp_project_params *params,
                            uint64_t *points, stp_error *err);

#endif
