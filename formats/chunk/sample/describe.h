/* Derives from patches what the entry of their chunk, or of a block, says of them: bounds that hold
 * although they are rounded to floats. Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_SAMPLE_DESCRIBE_H
#define STP_FORMATS_CHUNK_SAMPLE_DESCRIBE_H

#include "formats/chunk/chunk_file.h"

/* The least float that is no less than the value; the greatest that is no more. */
float stp_round_up(double value);
float stp_round_down(double value);

/* Sets patch_count, flags (two-sided, closed), box, cone and errors. count is at least 1. */
void stp_patches_describe(const stp_patch *patches, uint32_t count, stp_chunk_entry *entry);

#endif
