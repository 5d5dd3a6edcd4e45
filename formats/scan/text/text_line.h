/* Splits a line of numbers into fields and finds their separator.
 *
 * Fields are separated by bars, semicolons, single tabs, commas, or runs of spaces and tabs.
 * Spaces, quotation marks and brackets around fields are not part of them: `(1, 2, 3)` has three
 * fields. Brackets around one field alone, as `(m)`, are. A separator at the line's end begins no
 * further field. If commas do not separate, a number may have a decimal comma. Numbers may have
 * Fortran's exponents (1.5D+03) and marks of thousands (600'000.25). A line that is blank or begins
 * with #, //, % or ! does not count. Threads: any.
 */
#ifndef STP_FORMATS_SCAN_TEXT_TEXT_LINE_H
#define STP_FORMATS_SCAN_TEXT_TEXT_LINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum stp_separator {
    STP_SEPARATOR_BAR,
    STP_SEPARATOR_SEMICOLON,
    STP_SEPARATOR_TAB,
    STP_SEPARATOR_COMMA,
    STP_SEPARATOR_SPACE,
    STP_SEPARATOR_COUNT
} stp_separator;

static inline char stp_separator_character(stp_separator separator)
{
    static const char characters[STP_SEPARATOR_COUNT] = {'|', ';', '\t', ',', ' '};
    return characters[separator];
}

typedef struct stp_field {
    const char *begin, *end;
} stp_field;

/* Gets the next field from *at on and moves *at after its separator. False if there is none. */
bool stp_field_next(stp_separator separator, const char **at, const char *end, stp_field *field);
/* Reads the whole field as a number. False if it is none. Errors of range: as stp_number_parse. */
bool stp_field_number(stp_separator separator, stp_field field, double *value);

/* Whether the field stands for a number that is missing: nothing, or a word such as n/a or null. */
bool stp_field_is_missing(stp_field field);

/* Reads a colour in one piece as 0xRRGGBB. False if it is none. Colours are
 * - #rrggbb or #rrggbbaa; if `hex` is set, without the #, too;
 * - 0xrrggbb or 0xaarrggbb;
 * - a whole number, whose bits above 24 do not count;
 * - a number with a fraction: a float of these bits, as PCL writes it;
 * - nothing, or nan: black. */
bool stp_field_colour(stp_separator separator, stp_field field, bool hex, double *value);
/* Whether the field is #rrggbb or 0xrrggbb; or, if `bare` is set, also rrggbb. */
bool stp_field_is_hex(stp_field field, bool bare);

/* The number of fields of a line, and how many of them are numbers. */
typedef struct stp_field_count {
    uint32_t fields, numbers;
} stp_field_count;

stp_field_count stp_fields_count(stp_separator separator, const char *begin, const char *end);
/* The separator that makes most fields numbers; among equals, the one that leaves fewest other
 * fields. */
stp_separator stp_separator_find(const char *begin, const char *end);

/* The last character ends files that DOS programs wrote. */
static inline bool stp_is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\x1a';
}

/* Programs print points as (x, y, z), [x y z] or {x; y; z}. */
static inline bool stp_is_opening(char c)
{
    return c == '(' || c == '[' || c == '{';
}

static inline bool stp_is_closing(char c)
{
    return c == ')' || c == ']' || c == '}';
}

static inline bool stp_line_is_comment(const char *begin, const char *end)
{
    while (begin < end && stp_is_blank(*begin))
        begin++;
    return begin < end && (*begin == '#' || *begin == '%' || *begin == '!' ||
                           (*begin == '/' && end - begin > 1 && begin[1] == '/'));
}

/* Whether the line has a point of well-known text, POINT(1 2 3) or POINT Z (1 2 3). Among spaces
 * its word and its brackets are no fields, and a comma or semicolon behind it separates. */
bool stp_line_is_point_text(const char *begin, const char *end);

/* How many groups of fields in brackets follow one another. */
uint32_t stp_bracket_groups(const char *begin, const char *end);

/* True if the line counts: it is neither blank, nor brackets alone, nor a comment. */
static inline bool stp_line_counts(const char *begin, const char *end)
{
    while (begin < end &&
           (stp_is_blank(*begin) || stp_is_opening(*begin) || stp_is_closing(*begin)))
        begin++;
    return begin < end && !stp_line_is_comment(begin, end);
}

#endif
