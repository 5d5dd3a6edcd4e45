/* Codes the columns of a table by odds: each cell's odds follow from how large the cells before it
 * were, in its column and in the column beside it.
 *
 * A column does not store its frequencies, as column.h does, so tables of few rows stay small.
 * formats/SPEC.md, "Odds", has the arithmetic. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_ODDS_CELLS_H
#define STP_FORMATS_CHUNK_CODEC_ODDS_CELLS_H

#include "formats/chunk/codec/odds/number.h"
#include "formats/chunk/codec/table/table.h"

/* The odds that columns begin with, by the sign of their cells (0, 1, 2 for -1, 0, 1): made once
 * for the tables of a part. Begins with nothing known. */
typedef struct stp_first_odds {
    bool known[3];
    stp_number_odds of[3];
} stp_first_odds;

/* The odds of columns of a side, -1, 0 or 1, which are made once. */
const stp_number_odds *stp_number_odds_first(stp_first_odds *first, int side);

/* Appends the columns that are not in the mask of constant columns. Errors: OUT_OF_MEMORY. */
stp_status stp_cells_encode(const stp_table *table, uint64_t constant, stp_bytes *out,
                            stp_error *err);

/* Decodes them from all of bytes. Errors: CORRUPT, OUT_OF_MEMORY. */
stp_status stp_cells_decode(const uint8_t *bytes, size_t size, uint64_t constant, stp_table *table,
                            stp_error *err);

/* The same of a tight table, among other symbols; its odds are known. Errors: OUT_OF_MEMORY. */
stp_status stp_cells_put(const stp_table *table, uint64_t constant, stp_symbol_writer *w,
                         stp_error *err);
/* What does not fit into the bytes, the reader tells at their end. first: is used and added to;
 * NULL: the odds are known. Errors: OUT_OF_MEMORY. */
stp_status stp_cells_get(stp_symbol_reader *r, uint64_t constant, stp_first_odds *first,
                         const stp_table *table, stp_error *err);

#endif
