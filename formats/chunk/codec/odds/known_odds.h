/* The odds that a part begins with, if they are known: a column has one of a few curves for each
 * case of what stands before and beside a cell, as blocks of scans have them. formats/SPEC.md,
 * "Known odds", says what the numbers mean; known_curves.inc, known_columns.inc and
 * known_squares.inc have them. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_ODDS_KNOWN_ODDS_H
#define STP_FORMATS_CHUNK_CODEC_ODDS_KNOWN_ODDS_H

#include "formats/chunk/codec/odds/odds.h"

#include <stdbool.h>

/* Of a column: odds of cells; then those of whether it is constant, if the column before varies,
 * and if not. */
#define STP_KNOWN_CELLS 34
/* Those of columns of numbers but B, and of kinds. */
#define STP_KNOWN_NUMBERS 28
#define STP_KNOWN_KINDS 24
#define STP_KNOWN_HOW STP_KNOWN_CELLS
#define STP_KNOWN_COUNT (STP_KNOWN_HOW + 2)

/* The curves of a table's columns, STP_KNOWN_COUNT numbers each. squares: of blocks of squares;
 * level: 2 to 0; last: of last children. */
const uint8_t *stp_known_patches(bool squares);
const uint8_t *stp_known_vertices(bool squares);
const uint8_t *stp_known_level(bool squares, int level, bool last);
/* Of the table of squares, and of a ladder's. */
const uint8_t *stp_known_squares(void);
const uint8_t *stp_known_ladder(void);
/* Of colours by rows: of green, red, blue. */
const uint8_t *stp_known_colours(bool last);
/* Of last children that are told by parents: by class and how far they are off. */
const uint8_t *stp_known_last_colours(void);

/* Begins odds with a curve. */
void stp_known_begin(unsigned curve, stp_odds *out);
/* The same of several curves. */
void stp_known_cells(const uint8_t *curve, unsigned count, stp_odds *restrict out);

/* What is known of a row before it is decoded: bits 0-1 how many siblings of the child follow it,
 * bits 2-3 the fit of its parent, bit 4 whether the parent is closed. */
STP_INLINE uint8_t stp_row_kind_of(unsigned siblings_left, unsigned parent_flags)
{
    return (uint8_t)(siblings_left | (parent_flags >> 6 & 3u) << 2 | (parent_flags >> 3 & 1u) << 4);
}

/* ---- signed cells: SPEC.md, "Signed cells"; signed_curves.inc, signed_columns.inc ---- */

/* How many odds a column has that none is beside, or one. */
#define STP_SIGNED_ALONE (7u * 13u)
#define STP_SIGNED_BESIDE (7u * 5u * 7u)
/* The same by the number of a column of samples; 0: it does not go by signed cells. */
unsigned stp_signed_width(unsigned column);
/* The numbers of the curves that its odds begin with; level: 2 to 0. */
const uint8_t *stp_signed_column(int level, unsigned column);
/* Begins `count` odds with these curves: for level 0, where odds learn. */
void stp_signed_cells(const uint8_t *curve, unsigned count, stp_odds *restrict out);
/* The odds of all curves, by number: for levels 2 and 1, where odds do not learn. */
const stp_odds *stp_signed_curves(void);

#endif
