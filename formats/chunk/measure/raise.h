/* Raises the errors that a chunk stores, when chunks beside or under it changed.
 *
 * Samples stay as they are, and no error becomes less. Threads: any, one chunk each. */
#ifndef STP_FORMATS_CHUNK_MEASURE_RAISE_H
#define STP_FORMATS_CHUNK_MEASURE_RAISE_H

#include "formats/chunk/measure/overhang.h"

/* The errors that an inner chunk's level-0 samples carry at most, told by its patches. Free with
 * free(). Errors: OUT_OF_MEMORY. */
stp_status stp_carry_tell(const stp_chunk *chunk, stp_carry **out, stp_error *err);
/* Raises a patch's tangential errors to what was measured. */
void stp_overhang_raise(stp_patch *patch, const stp_overhang *measured);

#endif
