/* Errors, cone and bound of a patch recomputed from its decoded samples. */
#ifndef STP_FORMATS_CHUNK_VERIFY_ERRORS_H
#define STP_FORMATS_CHUNK_VERIFY_ERRORS_H

#include "formats/chunk/overhang.h"

/* NULL if every stored bound of the patch holds over its own level-0 samples, else what does not.
 * In a leaf these are the originals and the errors true ones; in an inner chunk they stand for
 * more, and what they imply is the least that the bounds must hold. Threads: any. */
const char *stp_verify_patch_errors(const stp_chunk *chunk, uint32_t index);

/* True if the stored tangential errors hold what was found. */
bool stp_verify_overhang(const stp_patch *patch, const stp_overhang *found);

#endif
