/* Lists the samples that compute shaders project. All processors choose levels and list samples at
 * once, while on a software driver a geometry shader sends its samples through one thread. The
 * patch vertices in STP_SIGHT_VERTICES (runtime/cut/sight.h) need no choice. Roads that choose
 * elsewhere pass in lists only. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_RUNS_H
#define STP_RUNTIME_DRAW_RUNS_H

#include "base/error.h"

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_project_params stp_project_params; /* runtime/draw/project.h */

/* Storage blocks of the shaders; other passes may use those from STP_STORAGE_FREE on. */
enum { STP_STORAGE_LISTED = 1, STP_STORAGE_RUNS = 2, STP_STORAGE_SEEN = 3, STP_STORAGE_FREE = 4 };
/* A uniform location that stp_runs_each leaves to its programs. */
enum { STP_UNIFORM_SETTING = 1 };

typedef struct stp_runs {
    GLuint program;
    GLuint patches, listed, quarters, runs, seen; /* buffers; patches and seen: by patch in sight */
    GLuint textures[2];                           /* of runs, seen */
    size_t run_bytes, seen_bytes;                 /* of the buffers */
    size_t listed_count, quarter_count, patch_count;
    size_t most_runs; /* that there may be */
    bool software;    /* the driver draws on the CPU */
    bool chosen;      /* all this is as stp_runs_choose left it */
    size_t run_count; /* samples in runs, if they were counted */
} stp_runs;

/* Programs of one compute shader that includes shaders/splat/listed.glsl: for the samples in runs,
 * for the listed ones, and for those of STP_SIGHT_QUARTERS, if there are any. Zero: none. */
typedef struct stp_each {
    GLuint runs, listed, quarters;
} stp_each;

/* file: the shader's name; folder, defines: as in stp_program_params. Errors: GL. */
stp_status stp_each_create(stp_each *out, const char *file, bool quarters, const char *folder,
                           const char *defines, stp_error *err);
void stp_each_destroy(stp_each *each);
/* Sets a uniform of all programs. */
void stp_each_set(const stp_each *each, GLint location, GLint value);

/* folder, defines: of the variant, as in stp_program_params. Errors: GL. */
stp_status stp_runs_create(stp_runs *out, const char *folder, const char *defines, stp_error *err);
void stp_runs_destroy(stp_runs *runs);

/* Chooses the levels of the patches in sight and lists their samples, beside the samples `listed`.
 * counts: waits for the GPU and adds all samples to *points; otherwise adds only `count`. If
 * params->keeps, takes what the last call found. */
void stp_runs_choose(stp_runs *runs, const stp_project_params *params, const uint32_t *listed,
                     size_t count, bool counts, uint64_t *points);
/* Takes only the samples `listed`. */
void stp_runs_take(stp_runs *runs, const uint32_t *listed, size_t count);
/* Number of places for the samples that were counted, including gaps in runs that are not full. */
size_t stp_runs_places(const stp_runs *runs);
/* The most places that there may be; nothing is waited for. */
size_t stp_runs_most_places(const stp_runs *runs);
/* Gives a buffer at least so many bytes, and a texture over it. What it held is lost. */
void stp_runs_reserve(GLuint *buffer, GLuint *texture, GLenum format, size_t *capacity,
                      size_t bytes);
/* Number of samples in the chosen levels, without those that a shader including listed.glsl counted
 * as dropped. Waits for the GPU. */
uint64_t stp_runs_count_drawn(const stp_runs *runs);
/* Runs the programs for each sample. first: the location of the uniform for the number of the first
 * place, or -1. */
void stp_runs_each(const stp_runs *runs, const stp_each *each, GLint first);

#endif
