/* The attributes of points in lines of text: columns with a name that points have no member for,
 * and intensities and classes that a sample's 8 bits do not hold.
 *
 * An attribute has the name that the header or --columns gives the column; an intensity without a
 * name is `intensity`. A column is an attribute only if the sample finds a number in it, so a
 * column of words is none, and a column without a name is passed over. The type is a 64-bit float:
 * the lines that are not read yet may have fractions, signs or more digits. It returns whole
 * numbers up to 2^53 and decimals of up to 15 digits as they stand in the file. Where a cell is
 * empty or no number, the attribute is NaN: missing. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_TEXT_TEXT_NUMBERS_H
#define STP_FORMATS_SCAN_TEXT_TEXT_NUMBERS_H

#include "base/error.h"
#include "formats/attribute/attribute.h"
#include "formats/scan/text/columns.h"

typedef struct stp_text_numbers {
    bool keep; /* attributes are wanted */
    stp_attribute_list list;
    uint8_t *packed; /* of the points read last */
    size_t capacity;
} stp_text_numbers;

/* Adds the attributes of the columns, which learn theirs. ranges: of the columns, by the sample.
 * byte_intensity: intensities range from 0 to 255. */
void stp_text_numbers_find(stp_text_numbers *numbers, stp_columns *columns,
                           const stp_column_range *ranges, bool byte_intensity);
/* Makes room for so many points and sets all their numbers to missing, if attributes are wanted.
 * Errors: OUT_OF_MEMORY. */
stp_status stp_text_numbers_begin(stp_text_numbers *numbers, size_t points, stp_error *err);
/* The room for the numbers of this point; NULL: none are wanted. */
uint8_t *stp_text_numbers_at(const stp_text_numbers *numbers, size_t point);
void stp_text_numbers_clear(stp_text_numbers *numbers);

#endif
