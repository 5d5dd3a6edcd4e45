/* Which number of a line of text means what.
 *
 * Told by names, in a header line or in a list that the user gives, else by what the numbers are.
 *
 * Names, whatever their case, without what follows ( or [, without a leading `scalar_`, and without
 * the characters _ - . and space: x (also easting, east, e), y (northing, north, n), z (elevation,
 * height, altitude, h), r g b (red green blue), i (intensity, reflectance, reflectivity,
 * amplitude), nx ny nz (normalx ...), class (classification, label); columns.c has them all. Of two
 * columns for one thing that with the earlier of these names is read, and of equals the first.
 *
 * By content, n numbers a line of which the first three are x y z; of the others
 *   - three in a row that have unit length, or are all zero, are the normal;
 *   - three in a row that are whole numbers within 0..255 or 0..65535, or fractions within 0..1
 * that are no normal, are red, green and blue. Where they can lie in two ways, the number before
 * and the number behind them both fitting, intensity comes first if the format says so, else the
 *     outer one that differs most from its neighbour is no colour;
 *   - a number that is always 255 just behind a colour of 0..255, or 1 behind fractions, is alpha;
 *   - one number that is left is the intensity; of several nothing is guessed.
 * So 3 are xyz; 4 xyz i; 6 xyz rgb, or xyz with a normal; 7 xyz i rgb, xyz rgb i or xyz rgb alpha;
 * 9 both colour and normal in either order; 10 the same with an intensity anywhere. Columns that
 * are not read are named in the scan's note left_out. Threads: any. */
#ifndef STP_FORMATS_SCAN_TEXT_COLUMNS_H
#define STP_FORMATS_SCAN_TEXT_COLUMNS_H

#include "base/error.h"
#include "formats/scan/text/text_line.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum stp_column {
    STP_COLUMN_X,
    STP_COLUMN_Y,
    STP_COLUMN_Z,
    STP_COLUMN_RED,
    STP_COLUMN_GREEN,
    STP_COLUMN_BLUE,
    STP_COLUMN_NX,
    STP_COLUMN_NY,
    STP_COLUMN_NZ,
    STP_COLUMN_INTENSITY,
    STP_COLUMN_CLASS,
    STP_COLUMN_COUNT,
    STP_COLUMN_NONE = STP_COLUMN_COUNT
} stp_column;

/* Columns from this one on are passed over. */
#define STP_COLUMNS_MAX 64u

typedef struct stp_columns {
    stp_separator separator;
    uint32_t count; /* fields of a line that are looked at, at most STP_COLUMNS_MAX */
    bool open_end;  /* lines may have more */
    uint8_t targets[STP_COLUMNS_MAX]; /* stp_column of each */
} stp_columns;

/* What the numbers of one column are, over the lines looked at. */
typedef struct stp_column_range {
    uint64_t count;     /* finite numbers; the rest is over these */
    double min, max;    /* 0 where there are none */
    bool whole;         /* all without a fraction */
    bool written_whole; /* all written without a point or an exponent */
    uint32_t decimals; /* most digits behind a point, trailing zeros apart; UINT32_MAX: exponents */
    uint64_t unit, zero; /* times that it begins three numbers of unit length, or three zeros */
    double step;         /* sum of the differences to the next column */
} stp_column_range;

typedef struct stp_columns_sample {
    uint32_t count; /* columns, at most STP_COLUMNS_MAX */
    uint64_t rows;
    stp_column_range ranges[STP_COLUMNS_MAX];
} stp_columns_sample;

/* "red", ...: for messages. */
const char *stp_column_name(stp_column column);
/* STP_POINT_HAS_*. */
uint32_t stp_columns_attributes(const stp_columns *columns);
/* Where the column is, STP_COLUMNS_MAX where it is not. */
uint32_t stp_columns_find(const stp_columns *columns, stp_column column);

/* From a header line; false if its fields do not name x, y and z. Colours and normals of fewer than
 * three columns are none. */
bool stp_columns_from_header(stp_columns *out, stp_separator separator, const char *begin,
                             const char *end);
/* From a list of names with commas, _ or - for columns to be passed over; out's separator is left.
 * Lines may have more columns. Errors: INVALID_ARGUMENT. */
stp_status stp_columns_from_list(stp_columns *out, const char *list, stp_error *err);

/* Adds a line to the sample, if it has as many fields as the sample has columns. */
void stp_columns_sample_add(stp_columns_sample *sample, stp_separator separator, const char *begin,
                            const char *end);
/* By the rules above. is_number says of each column whether it is one, text being passed over.
 * False if fewer than three are. */
bool stp_columns_guess(stp_columns *out, const stp_columns_sample *sample, const bool *is_number,
                       bool intensity_first);

#endif
