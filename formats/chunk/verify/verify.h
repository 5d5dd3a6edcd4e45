/* Checks everything that a chunk file promises: the library part of `stipple verify`.
 *
 * Compares every checksum, decodes every chunk, and checks what formats/SPEC.md lists under
 * "Invariants". Memory: a few megabytes a thread. Does not modify the file. */
#ifndef STP_FORMATS_CHUNK_VERIFY_VERIFY_H
#define STP_FORMATS_CHUNK_VERIFY_VERIFY_H

#include "base/pool.h"
#include "base/progress.h"
#include "formats/chunk/chunk_file.h"

/* Stops at the first fault: of the directory, then of the chunk of lowest id, for any number of
 * threads. The message names the chunk and, if the fault has them, patch and byte. Errors: CORRUPT
 * (a fault), IO, OUT_OF_MEMORY, UNSUPPORTED (codec), CANCELLED. */
stp_status stp_chunk_file_verify(stp_chunk_file *file, stp_pool *pool, const stp_progress *progress,
                                 stp_error *err);

#endif
