/* A picture of a chunk file as `render` makes it, but on the CPU: model, cut, patches in sight and
 * levels by the renderer's own code, the reconstruction by the reference.
 *
 * Ends the program by abort where something is not finite. Threads: one at a time. */
#ifndef STP_TESTS_FUZZ_CPU_PICTURE_H
#define STP_TESTS_FUZZ_CPU_PICTURE_H

#include "base/pool.h"

#include <stdbool.h>
#include <stdint.h>

/* Draws a small picture of a file. choice: decides view, threshold and reconstruction. sound:
 * whether `verify` calls the file so, and it must be drawn. pool: one thread. */
void cpu_picture_draw(const char *path, uint64_t choice, bool sound, stp_pool *pool);

#endif
