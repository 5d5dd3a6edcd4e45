/* The numbers of known odds. */
#include "formats/chunk/codec/odds/known_odds.h"

#include "base/wide.h"
#include "formats/chunk/codec/predict.h"
#include "formats/chunk/patch.h"

#include <string.h>

/* Of each curve, `below`. */
_Alignas(64) static const int16_t curves[] = {
#include "formats/chunk/codec/odds/known_curves.inc"
};
#define CURVE_COUNT (sizeof curves / sizeof *curves / STP_ODDS_SYMBOLS)
_Static_assert(CURVE_COUNT <= 256, "a curve's number is a byte");

/* Of each column of each table, the numbers of its curves: patches, level 3, elder and last
 * children of levels 2, 1, 0. */
static const uint8_t columns[] = {
#include "formats/chunk/codec/odds/known_columns.inc"
};
_Static_assert(sizeof columns == STP_KNOWN_COUNT * (STP_LINKED_PATCH_COLUMN_COUNT +
                                                    (size_t)7 * STP_SAMPLE_COLUMN_COUNT),
               "numbers of all columns");

const uint8_t *stp_known_patches(void)
{
    return columns;
}

const uint8_t *stp_known_vertices(void)
{
    return columns + (size_t)STP_KNOWN_COUNT * STP_LINKED_PATCH_COLUMN_COUNT;
}

const uint8_t *stp_known_level(int level, bool last)
{
    const size_t tables = 1 + 2 * (size_t)(STP_LEVEL_COUNT - 2 - level) + last;
    return stp_known_vertices() + STP_KNOWN_COUNT * STP_SAMPLE_COLUMN_COUNT * tables;
}

void stp_known_begin(unsigned curve, stp_odds *out)
{
    memcpy(out->below, curves + (size_t)STP_ODDS_SYMBOLS * curve, sizeof out->below);
}

STP_WIDE
void stp_known_cells(const uint8_t *curve, unsigned count, stp_odds *restrict out)
{
    for (unsigned i = 0; i < count; i++)
        for (unsigned s = 0; s < STP_ODDS_SYMBOLS; s++)
            out[i].below[s] = curves[(size_t)STP_ODDS_SYMBOLS * curve[i] + s];
}
