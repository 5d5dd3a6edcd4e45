/* Projection by compute shaders, without the rasteriser: samples are put into their pixels by all
 * processors at once. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_SCATTER_H
#define STP_RUNTIME_DRAW_SCATTER_H

#include "runtime/draw/runs.h"

/* Programs. Zero is none. */
typedef struct stp_scatter {
    GLuint depth, name;
} stp_scatter;

/* folder, defines: of the variant, as of stp_program_params. Errors: GL. */
stp_status stp_scatter_create(stp_scatter *out, const char *folder, const char *defines,
                              stp_error *err);
void stp_scatter_destroy(stp_scatter *scatter);

/* Puts the samples in sight into the pyramid's nearest samples, over what is there; the least
 * sample wins where depths are equal. Adds to *points the vertices that were listed apart;
 * stp_runs_count_drawn says how many others were drawn, if params->waits. Errors: GL (no memory),
 * LIMIT. */
stp_status stp_scatter_draw(const stp_scatter *scatter, stp_runs *runs,
                            const stp_project_params *params, uint64_t *points, stp_error *err);

#endif
