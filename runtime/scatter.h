/* Projection by compute shaders, without the rasteriser: levels are chosen and samples put into
 * their pixels by all processors at once, where a geometry shader's samples go through one thread
 * of a software driver. Patches' vertices that are listed apart (runtime/sight.h) need no choice.
 * Threads: the render thread. */
#ifndef STP_RUNTIME_SCATTER_H
#define STP_RUNTIME_SCATTER_H

#include "base/error.h"

#include <epoxy/gl.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_project_params stp_project_params; /* runtime/project.h */

typedef struct stp_scatter {
    GLuint runs_program, scatter_program;
    /* Buffers: patches in sight and vertices listed apart; samples; by patch in sight. */
    GLuint patches, vertices, runs, lattices;
    GLuint textures[2];              /* of runs, lattices */
    size_t run_bytes, lattice_bytes; /* of the buffers */
} stp_scatter;

/* folder, defines: of the variant, as of stp_program_params. Errors: GL. */
stp_status stp_scatter_create(stp_scatter *out, const char *folder, const char *defines,
                              stp_error *err);
void stp_scatter_destroy(stp_scatter *scatter);

/* Puts samples into the pyramid's nearest samples, over what is there; the least sample wins where
 * depths are equal. Adds to *points the samples drawn. Errors: GL (no memory), LIMIT. */
stp_status stp_scatter_draw(stp_scatter *scatter, const stp_project_params *params,
                            uint64_t *points, stp_error *err);

#endif
