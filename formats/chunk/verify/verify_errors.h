/* Errors, cone and bound of a patch recomputed from its decoded samples; tangential errors are
 * overhang.h's. */
#ifndef STP_FORMATS_CHUNK_VERIFY_VERIFY_ERRORS_H
#define STP_FORMATS_CHUNK_VERIFY_VERIFY_ERRORS_H

#include "formats/chunk/chunk_file.h"

/* NULL if every stored bound of the patch holds over its own level-0 samples, else what does not.
 * In a leaf these are the originals and the errors true ones; in an inner chunk they stand for
 * more, and what they imply is the least that the bounds must hold. Threads: any. */
const char *stp_verify_patch_errors(const stp_chunk *chunk, uint32_t index);

#endif
