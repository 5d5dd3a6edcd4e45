/* Builds the chunks of a repaired file that differ from the damaged one, and measures their errors
 * against the chunks around them. Threads: one. */
#ifndef STP_FORMATS_CHUNK_REPAIR_REPAIR_BUILD_H
#define STP_FORMATS_CHUNK_REPAIR_REPAIR_BUILD_H

#include "formats/chunk/repair/repair_plan.h"

/* Builds the chunks that replace payloads, tier by tier (one depth of the tree) from the leaves up.
 * Raises errors of kept chunks that new chunks beside or under them make too small. Errors: IO,
 * CORRUPT, UNSUPPORTED, OUT_OF_MEMORY, LIMIT, CANCELLED. */
stp_status stp_repair_build(stp_repair_plan *plan, stp_error *err);

#endif
