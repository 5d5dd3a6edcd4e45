/* The chunks of a repaired file that are not as they were: built, and measured against those around
 * them. Threads: one. */
#ifndef STP_FORMATS_CHUNK_REPAIR_SETTLE_H
#define STP_FORMATS_CHUNK_REPAIR_SETTLE_H

#include "formats/chunk/repair/repair_plan.h"

/* Builds what replaces payloads, tier by tier from the leaves on, and raises errors of kept chunks
 * that what is new beside or under them makes too small. Errors: IO, CORRUPT, UNSUPPORTED,
 * OUT_OF_MEMORY, LIMIT, CANCELLED. */
stp_status stp_repair_settle(stp_repair_plan *plan, stp_error *err);

#endif
