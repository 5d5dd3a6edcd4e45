/* Projection by compute shaders, without the rasteriser: all processors put samples into their
 * pixels at once. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_SCATTER_H
#define STP_RUNTIME_DRAW_SCATTER_H

#include "runtime/draw/runs.h"

/* Zero: none. */
typedef struct stp_scatter {
    stp_each depth, name;
} stp_scatter;

/* folder, defines: of the variant, as in stp_program_params. Errors: GL. */
stp_status stp_scatter_create(stp_scatter *out, const char *folder, const char *defines,
                              stp_error *err);
void stp_scatter_destroy(stp_scatter *scatter);

/* Puts the samples in sight into the pyramid's nearest samples, over those already there. If depths
 * are equal, the least sample wins. Adds to *points the patch vertices listed apart; if
 * params->waits, stp_runs_count_drawn tells how many others were drawn. Errors: GL (no memory),
 * LIMIT. */
stp_status stp_scatter_draw(const stp_scatter *scatter, stp_runs *runs,
                            const stp_project_params *params, uint64_t *points, stp_error *err);

#endif
