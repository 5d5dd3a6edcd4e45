/* Codes a table of a payload. Constant columns are stored as one value, the rest is coded.
 *
 * Bytes: u32 size of the rest; u64 mask, bit c set if all values of column c are equal, bit 55 if
 * the table is tight, bit 56 if patches are predicted by middles, bit 57 if squares follow the
 * table (square.h), bit 58 if a scale of 14 bytes follows the mask or, with bit 57, the squares are
 * on tilted planes, bit 59 if the columns are coded by odds, and in bits 60-63 the shift of the
 * table's normals; one i16 for each other set bit in order; then the other columns: by odds
 * (cells.h), or each in order (column.h). A table without rows is no bytes at all. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_TABLE_TABLE_CODE_H
#define STP_FORMATS_CHUNK_CODEC_TABLE_TABLE_CODE_H

#include "formats/chunk/codec/table/column.h"
#include "formats/chunk/codec/table/table.h"

/* Errors: OUT_OF_MEMORY, INTERNAL (Draco fails). */
stp_status stp_table_encode(const stp_table *table, stp_bytes *out, stp_error *err);

/* Decodes the block at the start of bytes into the table, whose counts the caller has set. *used:
 * the block's size in bytes. Errors: CORRUPT, OUT_OF_MEMORY. */
stp_status stp_table_decode(const uint8_t *bytes, size_t size, stp_table *table, size_t *used,
                            stp_error *err);

#endif
