/* The samples that compute shaders project: levels are chosen and samples listed by all processors
 * at once, where a geometry shader's samples go through one thread of a software driver. Patches'
 * vertices that are listed apart (runtime/cut/sight.h) need no choice; other roads give lists
 * alone. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_RUNS_H
#define STP_RUNTIME_DRAW_RUNS_H

#include "base/error.h"

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_project_params stp_project_params; /* runtime/draw/project.h */

/* Storage blocks of the shaders, and where those of other passes begin. */
enum { STP_BLOCK_LISTED = 1, STP_BLOCK_RUNS = 2, STP_BLOCK_LATTICES = 3, STP_BLOCK_FREE = 4 };
/* What stp_runs_each leaves to the program in use. */
enum { STP_UNIFORM_SETTING = 1 };

typedef struct stp_runs {
    GLuint program;
    GLuint patches, listed, runs, lattices; /* buffers: in sight; samples; -; by patch in sight */
    GLuint textures[2];                     /* of runs, lattices */
    size_t run_bytes, lattice_bytes;        /* of the buffers */
    size_t listed_count;
    bool chosen;      /* there are runs */
    size_t run_count; /* of samples that were chosen, where they were counted */
} stp_runs;

/* folder, defines: of the variant, as of stp_program_params. Errors: GL. */
stp_status stp_runs_create(stp_runs *out, const char *folder, const char *defines, stp_error *err);
void stp_runs_destroy(stp_runs *runs);

/* Chooses the levels of the patches in sight, and lists these samples beside theirs. counts: waits
 * for the GPU, and adds to *points how many there are; else the listed ones alone. Errors: LIMIT.
 */
stp_status stp_runs_choose(stp_runs *runs, const stp_project_params *params, const uint32_t *listed,
                           size_t count, bool counts, uint64_t *points, stp_error *err);
/* These samples alone. */
void stp_runs_take(stp_runs *runs, const uint32_t *listed, size_t count);
/* Places for all samples that were counted: theirs, and gaps where runs are not full. */
size_t stp_runs_places(const stp_runs *runs);
/* Samples of the chosen levels but for those that a shader that included listed.glsl has counted as
 * dropped. Waits for the GPU. */
uint64_t stp_runs_count_drawn(const stp_runs *runs);
/* Runs the program in use, which includes shaders/splat/listed.glsl, once for each sample. first:
 * the uniform that says which place the first invocation has, or -1. */
void stp_runs_each(const stp_runs *runs, GLint first);

#endif
