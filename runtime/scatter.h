/* Projection by compute shaders, without the rasteriser: levels are chosen and samples put into
 * their pixels by all processors at once, where a geometry shader's samples go through one thread
 * of a software driver. Threads: the render thread. */
#ifndef STP_RUNTIME_SCATTER_H
#define STP_RUNTIME_SCATTER_H

#include "runtime/chunk_cache.h"
#include "runtime/cut.h"
#include "runtime/pyramid.h"

typedef struct stp_scatter {
    GLuint runs_program, scatter_program;
    GLuint groups, runs, lattices;   /* buffers: of patches; of samples; by patch */
    GLuint textures[2];              /* of runs, lattices */
    size_t run_bytes, lattice_bytes; /* of the buffers */
    uint32_t (*list)[2];             /* groups: first patch, patches */
    size_t list_count, list_capacity;
} stp_scatter;

/* folder, defines: as of stp_project_create. Errors: GL. */
stp_status stp_scatter_create(stp_scatter *out, const char *folder, const char *defines,
                              stp_error *err);
void stp_scatter_destroy(stp_scatter *scatter);

/* Puts resident chunks into the pyramid's nearest samples, over what is there; the least sample
 * wins where depths are equal. first: of the passes over a picture. Adds to *points the samples
 * drawn. Errors: OUT_OF_MEMORY, GL (no memory). */
stp_status stp_scatter_draw(stp_scatter *scatter, const stp_model *model,
                            const stp_chunk_cache *cache, const stp_pyramid *pyramid,
                            const stp_draw *draws, size_t count, bool first, uint64_t *points,
                            stp_error *err);

#endif
