/* A C interface to Draco: codes a column of integers through its symbol coder.
 *
 * A stream is a complete Draco bitstream (version 2.3, point cloud, sequential encoding, one
 * generic one-component int16 attribute, no prediction) without its first 25 bytes. Those bytes
 * follow from the number of values, so they are not stored. The symbols behind them are coded and
 * decoded without the point cloud around them. Values keep their order; nothing is deduplicated or
 * quantised. Compares no checksums. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_TABLE_DRACO_SHIM_H
#define STP_FORMATS_CHUNK_CODEC_TABLE_DRACO_SHIM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#include "base/error.h"

#define STP_DRACO_VALUES_LIMIT 65536u

/* Encodes 1..limit values; *stream is malloc'd, free with free(). Errors: INVALID_ARGUMENT (count),
 * OUT_OF_MEMORY, INTERNAL (Draco fails). */
stp_status stp_draco_encode(const int16_t *values, uint32_t count, void **stream,
                            size_t *stream_bytes, stp_error *err);

/* Decodes a stream of exactly count values into the caller's array (undefined after a failure).
 * The stream must have passed stp_stream_check: Draco allocates by numbers in it. Errors:
 * INVALID_ARGUMENT (count), CORRUPT, OUT_OF_MEMORY. */
stp_status stp_draco_decode(const void *stream, size_t stream_bytes, int16_t *values,
                            uint32_t count, stp_error *err);

#ifdef __cplusplus
}
#endif

#endif
