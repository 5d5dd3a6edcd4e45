/* Checks a patch's errors, cone and bound: recomputes them from its decoded samples. overhang.h
 * checks tangential errors. */
#ifndef STP_FORMATS_CHUNK_VERIFY_VERIFY_ERRORS_H
#define STP_FORMATS_CHUNK_VERIFY_VERIFY_ERRORS_H

#include "formats/chunk/chunk_file.h"

/* Returns NULL if every stored bound of the patch holds over its own level-0 samples, else what
 * does not hold. In a leaf, level 0 is the originals, so the errors are the true ones. In an inner
 * chunk, level-0 samples stand for more, so what they imply is the least that the bounds must hold.
 * Threads: any. */
const char *stp_verify_patch_errors(const stp_chunk *chunk, uint32_t index);

#endif
