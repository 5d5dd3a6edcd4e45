/* Codes the columns of a table by odds: each cell's odds follow from how large the cells before it
 * were, in its column and in the column beside it.
 *
 * A column does not store its frequencies, as column.h does, so tables of few rows stay small.
 * formats/SPEC.md, "Odds", has the arithmetic. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_CELLS_H
#define STP_FORMATS_CHUNK_CODEC_CELLS_H

#include "formats/chunk/codec/table.h"

/* Appends the columns that are not in the mask of constant columns. Errors: OUT_OF_MEMORY. */
stp_status stp_cells_encode(const stp_table *table, uint64_t constant, stp_bytes *out,
                            stp_error *err);

/* Decodes them from all of bytes. Errors: CORRUPT, OUT_OF_MEMORY. */
stp_status stp_cells_decode(const uint8_t *bytes, size_t size, uint64_t constant, stp_table *table,
                            stp_error *err);

#endif
