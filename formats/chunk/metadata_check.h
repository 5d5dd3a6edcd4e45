/* Checks what every reader of a chunk file's metadata relies on (SPEC.md, "Metadata"), when the
 * file is opened. Does not check the key "closed": stp_outside_read does, where the key is read. */
#ifndef STP_FORMATS_CHUNK_METADATA_CHECK_H
#define STP_FORMATS_CHUNK_METADATA_CHECK_H

#include "base/error.h"

#include <stddef.h>
#include <stdint.h>

/* text: text[bytes] must be zero. point_count: the file's. Errors, without the path: CORRUPT (a
 * zero byte, no JSON object, wrong records of repairs). */
stp_status stp_metadata_check(const char *text, size_t bytes, uint64_t point_count, stp_error *err);

#endif
