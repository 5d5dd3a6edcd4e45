/* Shows an attribute: decoded samples carry its values in place of their intensities.
 *
 * A value becomes 0 to 255 between the two ends of a range. Threads: any; a lock guards the
 * numbers. */
#ifndef STP_RUNTIME_STREAM_SHOWN_H
#define STP_RUNTIME_STREAM_SHOWN_H

#include "runtime/stream/numbers.h"

typedef struct stp_shown stp_shown;

/* range: the values at both ends; if they do not rise, it becomes the 2nd and 98th percentile of
 * the root's samples. The file is borrowed. Errors: NOT_FOUND (no such attribute; the message has
 * those there are), INVALID_ARGUMENT (the samples have it themselves), those of reading. */
stp_status stp_shown_create(stp_shown **out, stp_chunk_file *file, const char *name,
                            double range[2], stp_error *err);
/* Replaces the intensities of a decoded block. chunk: the block's, as in *block. Errors: IO,
 * CORRUPT, CANCELLED, OUT_OF_MEMORY. */
stp_status stp_shown_fill(stp_shown *shown, const stp_numbers_block *block, stp_chunk *chunk,
                          stp_error *err);
/* Its name, and the values at both ends of the range. */
const char *stp_shown_name(const stp_shown *shown, double range[2]);
void stp_shown_destroy(stp_shown **shown);

#endif
