/* The numbers of known odds. */
#include "formats/chunk/codec/odds/known_odds.h"

#include "base/wide.h"
#include "formats/chunk/codec/predict/predict.h"
#include "formats/chunk/sample/patch.h"

#include <string.h>

/* Of each curve, `below`. */
_Alignas(64) static const int16_t curves[] = {
#include "formats/chunk/codec/odds/known_curves.inc"
};
#define CURVE_COUNT (sizeof curves / sizeof *curves / STP_ODDS_SYMBOLS)
_Static_assert(CURVE_COUNT <= 256, "a curve's number is a byte");

/* Columns of tables that any block has: patches, level 3, elder and last children of levels 2, 1,
 * 0. */
#define COMMON_COLUMNS (STP_LINKED_PATCH_COLUMN_COUNT + (size_t)7 * STP_SAMPLE_COLUMN_COUNT)
/* Columns of the table of squares, of a ladder, and channels of colours. */
#define SQUARE_COLUMNS 11u
#define LADDER_COLUMNS 2u
#define CHANNELS 3u

/* Of each column of each table, the numbers of its curves. */
static const uint8_t columns[] = {
#include "formats/chunk/codec/odds/known_columns.inc"
};
_Static_assert(sizeof columns == STP_KNOWN_COUNT * COMMON_COLUMNS, "numbers of all columns");
/* The same of squares; then come their own table, ladders, colours of elder and last children, and
 * of last ones that are told by parents. */
static const uint8_t square_columns[] = {
#include "formats/chunk/codec/odds/known_squares.inc"
};
_Static_assert(sizeof square_columns == STP_KNOWN_COUNT * (COMMON_COLUMNS + SQUARE_COLUMNS +
                                                           LADDER_COLUMNS + (size_t)3 * CHANNELS),
               "numbers of all columns");

/* The same of columns that go by signed cells, of levels 2, 1, 0. */
_Alignas(64) static const int16_t signed_curves[] = {
#include "formats/chunk/codec/odds/signed_curves.inc"
};
_Static_assert(sizeof signed_curves == sizeof curves, "a curve's number is a byte");
static const uint8_t signed_columns[] = {
#include "formats/chunk/codec/odds/signed_columns.inc"
};
#define SIGNED_ODDS ((size_t)4 * STP_SIGNED_ALONE + (size_t)3 * STP_SIGNED_BESIDE)
_Static_assert(sizeof signed_columns == 3 * SIGNED_ODDS, "numbers of all columns");

const uint8_t *stp_known_patches(bool squares)
{
    return squares ? square_columns : columns;
}

const uint8_t *stp_known_vertices(bool squares)
{
    return stp_known_patches(squares) + (size_t)STP_KNOWN_COUNT * STP_LINKED_PATCH_COLUMN_COUNT;
}

const uint8_t *stp_known_level(bool squares, int level, bool last)
{
    const size_t tables = 1 + 2 * (size_t)(STP_LEVEL_COUNT - 2 - level) + last;
    return stp_known_vertices(squares) + STP_KNOWN_COUNT * STP_SAMPLE_COLUMN_COUNT * tables;
}

const uint8_t *stp_known_squares(void)
{
    return square_columns + STP_KNOWN_COUNT * COMMON_COLUMNS;
}

const uint8_t *stp_known_ladder(void)
{
    return stp_known_squares() + (size_t)STP_KNOWN_COUNT * SQUARE_COLUMNS;
}

const uint8_t *stp_known_colours(bool last)
{
    return stp_known_ladder() +
           (size_t)STP_KNOWN_COUNT * (LADDER_COLUMNS + (size_t)(last ? CHANNELS : 0));
}

const uint8_t *stp_known_last_colours(void)
{
    return stp_known_colours(true) + (size_t)STP_KNOWN_COUNT * CHANNELS;
}

void stp_known_begin(unsigned curve, stp_odds *out)
{
    memcpy(out->below, curves + (size_t)STP_ODDS_SYMBOLS * curve, sizeof out->below);
}

STP_INLINE void cells_begin(const int16_t *all, const uint8_t *curve, unsigned count,
                            stp_odds *restrict out)
{
    for (unsigned i = 0; i < count; i++)
        memcpy(out[i].below, all + (size_t)STP_ODDS_SYMBOLS * curve[i], sizeof out[i].below);
}

STP_WIDE
void stp_known_cells(const uint8_t *curve, unsigned count, stp_odds *restrict out)
{
    cells_begin(curves, curve, count, out);
}

/* ---- by signed cells ---- */

unsigned stp_signed_width(unsigned column)
{
    static const uint8_t width[STP_SAMPLE_COLUMN_COUNT] = {
        [STP_COLUMN_RADIUS] = STP_SIGNED_ALONE,     [STP_COLUMN_NORMAL_U] = STP_SIGNED_ALONE,
        [STP_COLUMN_NORMAL_V] = STP_SIGNED_BESIDE,  [STP_COLUMN_GREEN] = STP_SIGNED_ALONE,
        [STP_COLUMN_RED] = STP_SIGNED_BESIDE,       [STP_COLUMN_BLUE] = STP_SIGNED_BESIDE,
        [STP_COLUMN_POSITION_A] = STP_SIGNED_ALONE,
    };
    return width[column];
}

const uint8_t *stp_signed_column(int level, unsigned column)
{
    const uint8_t *out = signed_columns + SIGNED_ODDS * (size_t)(STP_LEVEL_COUNT - 2 - level);
    for (unsigned c = 0; c < column; c++)
        out += stp_signed_width(c);
    return out;
}

STP_WIDE
void stp_signed_cells(const uint8_t *curve, unsigned count, stp_odds *restrict out)
{
    cells_begin(signed_curves, curve, count, out);
}

const stp_odds *stp_signed_curves(void)
{
    return (const stp_odds *)(const void *)signed_curves;
}
