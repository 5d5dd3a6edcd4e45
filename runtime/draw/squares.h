/* Draws squares of grids as triangles, and those of maps as triangles or as splats: lists the
 * squares with those beside them, so that the shaders find the neighbours of every sample
 * (shaders/project/square.glsl, map.glsl).
 *
 * Squares beside each other are of one grid. Of upright rasters these are squares of a model whose
 * places and steps on the map fit; of others, squares of the same raster in the same chunk.
 * Elsewhere surfaces go on by half a cell and overlap. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_SQUARES_H
#define STP_RUNTIME_DRAW_SQUARES_H

#include "base/error.h"
#include "runtime/draw/splat.h"
#include "runtime/gl/gpu_layout.h"

#include <epoxy/gl.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_project_params stp_project_params; /* runtime/draw/project.h */

/* Zero: none. */
typedef struct stp_squares {
    GLuint list, list_quarters, program,
        resolve;     /* the project compiles them, and those of splats */
    int maps;        /* of the variant */
    stp_splat splat; /* if maps are drawn as splats */
    GLuint buffer, texture;
    /* What square.comp lists of some squares: places, triangles, a draw a square, cells with
     * quarters. */
    GLuint places, triangle_names, draws, quarters, place_texture, triangle_texture;
    stp_gpu_square *records; /* of the last pass */
    size_t count, capacity;
    size_t triangles;            /* so many are drawn as triangles, the others as splats */
    struct stp_square_key *keys; /* where each is in its grid */
    uint32_t *heads;             /* by bucket: its first key */
    size_t key_capacity, head_count, head_capacity;
} stp_squares;

void stp_squares_destroy(stp_squares *squares);

/* The name of the sample that a pixel's name stands for: of a grid, or else as it is; UINT32_MAX:
 * not known. */
GLuint stp_squares_sample(const stp_squares *squares, GLuint name);

/* Lists the squares in sight (STP_SIGHT_SQUARES), at least one, and adds their samples to *points.
 * They stay bound as textures for the shaders that resolve. Errors: OUT_OF_MEMORY, LIMIT (more
 * squares than names tell apart). */
stp_status stp_squares_list(stp_squares *squares, const stp_project_params *params,
                            uint64_t *points, stp_error *err);
/* Draws those that are drawn as triangles. */
void stp_squares_draw(const stp_squares *squares, const stp_project_params *params);

#endif
