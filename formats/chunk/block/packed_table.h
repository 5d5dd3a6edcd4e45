/* A table of blocks in fewer bytes: first byte 0 of all records, then byte 1 of all, and so on, in
 * a zstd frame behind a head (formats/SPEC.md, "The packed table"). A view reads the table before
 * all else, and half of it is the same from record to record.
 *
 * Pure functions. Threads: any. */
#ifndef STP_FORMATS_CHUNK_BLOCK_PACKED_TABLE_H
#define STP_FORMATS_CHUNK_BLOCK_PACKED_TABLE_H

#include "formats/chunk/codec/table/column.h"
#include "formats/chunk/layout.h"

/* Tables of fewer records are not worth a frame. */
#define STP_PACKED_LEAST 128u
/* A table that becomes more times as small is not packed: few bytes would ask for much memory. */
#define STP_PACKED_RATIO_MOST 16u

/* Appends a packed table of `count` records of STP_BLOCK_BYTES; nothing if they are fewer than
 * STP_PACKED_LEAST, so many that a header has no room for their number, or so much alike that they
 * become more than STP_PACKED_RATIO_MOST times as small. Errors: OUT_OF_MEMORY. */
stp_status stp_table_pack(const uint8_t *records, size_t count, stp_bytes *out, stp_error *err);

/* Sets *out to the `count` records of a packed table; free with free(). Errors: CORRUPT (it is not
 * a table of so many), OUT_OF_MEMORY. */
stp_status stp_table_unpack(const uint8_t *packed, size_t size, uint64_t count, uint8_t **out,
                            stp_error *err);

/* How many bytes the packed table of `count` records takes that begins at `packed`, of at most
 * `left`; 0: none begins there. */
size_t stp_packed_table_bytes(const uint8_t *packed, size_t left, uint64_t count);

#endif
