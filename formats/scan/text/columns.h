/* Finds what each number of a line of text means.
 *
 * Names decide: a header line, or a list that the user gives. Without names the numbers decide.
 *
 * Names: formats/scan/column_name.h. Columns rgb, color, hex and the like are colours in one piece,
 * unless their numbers are within -65536..65535, or fractions other than bits of floats: then they
 * are the intensity. If they or a class have words alone, these are passed over. If two columns
 * mean the same, the one whose name is earlier in its list is read; if their names are equal, the
 * first column. Columns with other names are attributes (text_numbers.h).
 *
 * By content, of n numbers per line the first three are x y z. But if there are more, and the first
 * is the point's number or its time, x is the second; if the first two are its row and column, x is
 * the third. They are if both are whole and of 16 bits, go on from line to line, in 99 of 100, as
 * pixels of an image do, row by row or column by column, and x y z have fractions, and then come
 * whole numbers, so that there are 6 or more. The first is a number if it is whole, grows in every
 * line, by one in 9 of 10, and at least two of the three after it have fractions, all three if the
 * last of four differs. It is a time if it counts seconds since 1970, or milli-, micro- or
 * nanoseconds, never falls, and is a hundred times what follows; or if in a hundred lines or more
 * it never falls, and is written with 5 decimals at least, two more than each of the next three,
 * which differ and have fractions.
 * If a name or a growing whole number comes first and words come after x y z, a surveyor wrote it:
 * then the northing comes before the easting (PNEZD), unless the numbers speak against it.
 * The others:
 *   - Three in a row that have unit length, or are all zero, are the normal.
 *   - Three in a row that are whole numbers within 0..255 or 0..65535, or fractions within 0..1,
 *     and no normal, are red, green and blue. If they can lie in two ways, because the number
 *     before and the number after both fit, the format decides: if it puts intensity first, the
 *     first of the four is the intensity. Else the outer number that differs most from its
 *     neighbour is no colour.
 *   - A number directly after a colour is alpha if it is always 255 (colours 0..255) or 1
 *     (fractions).
 *   - In a hundred lines or more, whole numbers up to 31 (7, if all are equal) are classes, returns
 *     or flags. Three numbers are no colours if two are such and one of these is 7 at most, unless
 *     they are one colour for all that exceeds 31. Nor are they an intensity beside another number.
 *     A lone one is the class.
 *   - If one number is left, it is the intensity. So is one beside a time: the time never falls,
 *     and has fractions or exceeds 65535. Else, if several are left, nothing is guessed.
 *   - #rrggbb or 0xrrggbb is a colour in one piece. So is the number that is left if all are from
 *     -2^24 to -1, some below -2^16, or from 0xFF000000 to 2^32 - 1.
 * So 3 numbers are xyz; 4 xyz i; 6 xyz rgb, or xyz with a normal; 7 xyz i rgb, xyz rgb i or xyz rgb
 * alpha; 9 both colour and normal in either order; 10 the same with an intensity anywhere. Colours
 * that are all zero are none, also if they have names (text.c). The scan's note left_out names the
 * columns that are not read. Threads: any. */
#ifndef STP_FORMATS_SCAN_TEXT_COLUMNS_H
#define STP_FORMATS_SCAN_TEXT_COLUMNS_H

#include "base/error.h"
#include "formats/attribute/attribute.h"
#include "formats/scan/column_name.h"
#include "formats/scan/text/text_line.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Columns from this number on are ignored. */
#define STP_COLUMNS_MAX 64u

typedef struct stp_columns {
    stp_separator separator;
    uint32_t count;                   /* fields per line that are used, at most STP_COLUMNS_MAX */
    bool open_end;                    /* lines may have more fields */
    bool hex;                         /* colours in one piece are hexadecimal without a sign */
    bool angles;                      /* x and y are named longitude and latitude */
    bool depths;                      /* z is named a depth: see text.h */
    bool northing_first;              /* y before x, by a surveyor's custom alone */
    uint8_t targets[STP_COLUMNS_MAX]; /* stp_column of each */
    uint8_t extras[STP_COLUMNS_MAX];  /* 1 + index of its attribute (text_numbers.h); 0: none */
    char names[STP_COLUMNS_MAX]
              [STP_ATTRIBUTE_NAME_BYTES]; /* by header, or attributes by list; "": none */
} stp_columns;

/* Statistics of one column over the sampled lines. */
typedef struct stp_column_range {
    uint64_t count;     /* finite numbers; all other members are about these */
    double min, max;    /* 0 if there are none */
    double second;      /* least number above min; min: there is none */
    bool whole;         /* no number has a fraction */
    bool written_whole; /* no number is written with a point or an exponent */
    uint32_t
        decimals;   /* most digits after a point, without trailing zeros; UINT32_MAX: exponents */
    uint64_t hexes; /* 6 or 8 hexadecimal digits, perhaps after # or 0x */
    bool padded;    /* some of these are digits with a zero in front */
    uint64_t unit, zero; /* lines where it begins 3 numbers of unit length, or 3 zeros */
    double step;         /* sum of the differences to the next column */
    double last;         /* the number of the line before */
    uint64_t falls;      /* lines whose number is less than the last, or none */
} stp_column_range;

typedef struct stp_columns_sample {
    uint32_t count; /* columns, at most STP_COLUMNS_MAX */
    bool open_end;  /* lines with more count, too */
    uint64_t rows;
    uint64_t successors, repeats; /* lines whose first number is one more than that of the line
                                     before; equal */
    uint64_t behind[2];           /* lines that do not come after the one before by their first two
                                     numbers; by the second, then the first */
    stp_column_range ranges[STP_COLUMNS_MAX];
} stp_columns_sample;

/* Copies a name as far as it fits, without characters that are not plain. */
void stp_column_copy_name(char *out, size_t capacity, stp_field field);
/* STP_POINT_HAS_*. */
uint32_t stp_columns_attributes(const stp_columns *columns);
/* The index of the column; STP_COLUMNS_MAX if there is none. */
uint32_t stp_columns_find(const stp_columns *columns, stp_column column);

/* Gets the next name of a header, as stp_field_next does; units are none. */
bool stp_columns_next_name(stp_separator separator, const char **at, const char *end,
                           stp_field *field);
/* Takes the columns from a header line. False if its fields do not name x, y and z. Colours and
 * normals need all three columns. */
bool stp_columns_from_header(stp_columns *out, stp_separator separator, const char *begin,
                             const char *end);
/* Whether a comment names x, y and z. */
bool stp_comment_names_axes(const char *begin, const char *end);
/* Takes the columns from a list of names with commas; _ or - skips a column. Leaves out's
 * separator. Lines may have more columns. others: names of attributes are allowed; they begin with
 * a letter. Errors: INVALID_ARGUMENT. */
stp_status stp_columns_from_list(stp_columns *out, const char *list, bool others, stp_error *err);

/* Adds a line to the sample, if it has as many fields as the sample has columns (or more:
 * open_end). */
void stp_columns_sample_add(stp_columns_sample *sample, stp_separator separator, const char *begin,
                            const char *end);
/* Applies the rules above. is_number says for each column whether it is a number; text is skipped.
 * False if fewer than three columns are numbers. */
bool stp_columns_guess(stp_columns *out, const stp_columns_sample *sample, const bool *is_number,
                       bool intensity_first);

#endif
