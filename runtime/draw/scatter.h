/* Projection by compute shaders, without the rasteriser: all processors put samples into their
 * pixels at once. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_SCATTER_H
#define STP_RUNTIME_DRAW_SCATTER_H

#include "runtime/draw/runs.h"
#include "runtime/gl/shader.h"

/* The programs of both passes over all samples. */
typedef struct stp_scatter_passes {
    stp_each depth, name;
} stp_scatter_passes;

/* Zero: none. */
typedef struct stp_scatter {
    /* The first: both passes project each sample. The second: the first pass keeps where samples
     * lie, for the second one. */
    stp_scatter_passes passes[2];
    GLuint places, places_texture; /* of the samples, 8 bytes each */
    size_t place_bytes;
    const char *folder; /* for programs that are compiled when they are needed */
    char defines[STP_VARIANT_DEFINES_BYTES];
} stp_scatter;

/* Compiles the programs that pictures usually need. folder, defines: of the variant, as in
 * stp_program_params; folder is borrowed. Errors: GL. */
stp_status stp_scatter_create(stp_scatter *out, const char *folder, const char *defines,
                              stp_error *err);
void stp_scatter_destroy(stp_scatter *scatter);

/* Puts the samples in sight into the pyramid's nearest samples, over those already there. If depths
 * are equal, the least sample wins. Adds to *points the patch vertices listed apart; if
 * params->waits, stp_runs_count_drawn tells how many others were drawn. Errors: GL (no memory),
 * LIMIT. */
stp_status stp_scatter_draw(stp_scatter *scatter, stp_runs *runs, const stp_project_params *params,
                            uint64_t *points, stp_error *err);

#endif
