/* What all who read a chunk file's metadata rely on (SPEC.md, "Metadata"); asked where the file is
 * opened. Does not judge the key "closed": stp_outside_read does, where it is read. */
#ifndef STP_FORMATS_CHUNK_METADATA_CHECK_H
#define STP_FORMATS_CHUNK_METADATA_CHECK_H

#include "base/error.h"

#include <stddef.h>
#include <stdint.h>

/* text: zero at text[bytes]. point_count: the file's. Errors: CORRUPT (a zero byte, no JSON object,
 * records of repairs that are none), without the path. */
stp_status stp_metadata_check(const char *text, size_t bytes, uint64_t point_count, stp_error *err);

#endif
