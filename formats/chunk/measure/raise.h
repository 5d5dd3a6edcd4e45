/* Raises the errors that a chunk stores, when chunks beside or under it changed.
 *
 * Samples stay as they are, and no error becomes less. Threads: any, one chunk each. */
#ifndef STP_FORMATS_CHUNK_MEASURE_RAISE_H
#define STP_FORMATS_CHUNK_MEASURE_RAISE_H

#include "formats/chunk/measure/overhang.h"

/* The errors that an inner chunk's level-0 samples carry at most, told by its patches. Free with
 * free(). Errors: OUT_OF_MEMORY. */
stp_status stp_carry_tell(const stp_chunk *chunk, stp_carry **out, stp_error *err);
/* Measures a chunk as stp_overhang_measure does and raises its patches' tangential errors to what
 * comes out. Errors: those of measuring. */
stp_status stp_overhang_raise(stp_chunk *chunk, const stp_carry *carry,
                              const stp_surroundings *around, stp_error *err);

#endif
