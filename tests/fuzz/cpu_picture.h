/* Draws a chunk file's picture as `render` does, but on the CPU. The renderer's own code finds the
 * model, the cut, the patches in sight and the levels; the reference does the reconstruction.
 *
 * Aborts the program if a value is not finite. Threads: one at a time. */
#ifndef STP_TESTS_FUZZ_CPU_PICTURE_H
#define STP_TESTS_FUZZ_CPU_PICTURE_H

#include "base/pool.h"

#include <stdbool.h>
#include <stdint.h>

/* Draws a small picture of a file. choice decides view, threshold and reconstruction. sound:
 * `verify` calls the file sound, so drawing must succeed. pool: one thread. */
void cpu_picture_draw(const char *path, uint64_t choice, bool sound, stp_pool *pool);

#endif
