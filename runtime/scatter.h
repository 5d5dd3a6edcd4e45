/* Projection by compute shaders, without the rasteriser: samples are put into their pixels by all
 * processors at once. Threads: the render thread. */
#ifndef STP_RUNTIME_SCATTER_H
#define STP_RUNTIME_SCATTER_H

#include "runtime/runs.h"

/* folder, defines: of the variant, as of stp_program_params. Errors: GL. */
stp_status stp_scatter_create(GLuint *program, const char *folder, const char *defines,
                              stp_error *err);

/* Puts the samples in sight into the pyramid's nearest samples, over what is there; the least
 * sample wins where depths are equal. Adds to *points the samples drawn. Errors: GL (no memory),
 * LIMIT. */
stp_status stp_scatter_draw(GLuint program, stp_runs *runs, const stp_project_params *params,
                            uint64_t *points, stp_error *err);

#endif
