/* Splits a line of numbers into fields. */
#include "formats/scan/text/text_line.h"

#include "formats/scan/number.h"

#include <float.h>
#include <math.h>
#include <string.h>
#include <strings.h>

/* Longer than any number that anyone writes on purpose. */
#define STP_FIELD_CHARS_MAX 64

static bool separates(stp_separator separator, char c)
{
    return c == stp_separator_character(separator) ||
           (separator == STP_SEPARATOR_SPACE && c == '\t');
}

/* True before a field for a blank that is not the separator itself, and for brackets. */
static bool is_padding(stp_separator separator, char c)
{
    return (stp_is_blank(c) && (separator != STP_SEPARATOR_TAB || c != '\t')) || stp_is_opening(c);
}

/* Whether brackets close here, and others open next: `(1, 2, 3) (4, 5, 6)` has six fields. */
static bool reopens(const char *at, const char *end)
{
    if (!stp_is_closing(*at++))
        return false;
    while (at < end && stp_is_blank(*at))
        at++;
    return at < end && stp_is_opening(*at);
}

/* The end of brackets around a field among spaces that a comma or the like follows, perhaps after a
 * quotation mark: of `(1 2 3)",4`. NULL: there is none. */
static const char *closed_before(const char *at, const char *end)
{
    if (!stp_is_closing(*at++))
        return NULL;
    at += at < end && *at == '"';
    return at < end && (*at == ',' || *at == ';') ? at : NULL;
}

static const char *find_stop(stp_separator separator, const char *begin, const char *end)
{
    const char *stop = begin;
    bool opens = false; /* within the field, as brackets of units do */
    if (begin < end && *begin == '"') {
        const char *close = memchr(begin + 1, '"', (size_t)(end - begin - 1));
        stop = close ? close : begin;
    }
    for (; stop < end && !separates(separator, *stop); stop++) {
        opens = opens || stp_is_opening(*stop);
        if (!opens &&
            (reopens(stop, end) || (separator == STP_SEPARATOR_SPACE && closed_before(stop, end))))
            break;
    }
    return stop;
}

static const char *skip_blanks(const char *at, const char *end)
{
    while (at < end && stp_is_blank(*at))
        at++;
    return at;
}

/* Skips `POINT Z (` of well-known text, and a quotation mark before it. */
static const char *skip_point(const char *begin, const char *end)
{
    const char *at = begin < end && *begin == '"' ? begin + 1 : begin;
    if (end - at < 6 || strncasecmp(at, "POINT", 5) != 0)
        return begin;
    at = skip_blanks(at + 5, end);
    at += at < end && (*at | 32) == 'z';
    at += at < end && (*at | 32) == 'm';
    at = skip_blanks(at, end);
    return at < end && *at == '(' ? at + 1 : begin;
}

bool stp_line_is_point_text(const char *begin, const char *end)
{
    for (const char *at = begin; at < end; at++)
        if ((*at | 32) == 'p' && skip_point(at, end) > at)
            return true;
    return false;
}

/* Leaves out blanks at a field's end, and brackets that do not open within it. */
static const char *trim_end(const char *begin, const char *stop)
{
    bool opens = false;
    for (const char *at = begin; at < stop; at++)
        opens = opens || stp_is_opening(*at);
    if (!opens && stop - begin > 1 && stop[-1] == '"' && stp_is_closing(stop[-2]))
        stop--;
    while (stop > begin && (stp_is_blank(stop[-1]) || (!opens && stp_is_closing(stop[-1]))))
        stop--;
    return stop;
}

/* Brackets around a field alone are part of it: words say so of years, and headers of units. */
static void keep_pair(const char *first, const char *last, stp_field *field)
{
    if (field->begin > first && field->end < last && stp_is_opening(field->begin[-1]) &&
        stp_is_closing(*field->end)) {
        field->begin--;
        field->end++;
    }
}

bool stp_field_next(stp_separator separator, const char **at, const char *end, stp_field *field)
{
    const bool spaced = separator == STP_SEPARATOR_SPACE;
    const char *first, *stop;
    do {
        first = field->begin = *at;
        if (first == end)
            return false;
        while (field->begin < end && is_padding(separator, *field->begin))
            field->begin++;
        if (field->begin < end && spaced && strchr("Pp\"", *field->begin))
            field->begin = skip_point(field->begin, end);
        while (field->begin < end && spaced && is_padding(separator, *field->begin))
            field->begin++;
        if (field->begin == end && spaced) {
            *at = end;
            return false;
        }
        stop = find_stop(separator, field->begin, end);
        const char *closed = spaced && stop < end ? closed_before(stop, end) : NULL;
        *at = closed ? closed + 1 : stop < end ? stop + 1 : end;
        stop = stop < end && stp_is_closing(*stop) ? stop + 1 : stop;
        field->end = trim_end(field->begin, stop);
        keep_pair(first, stop, field);
    } while (field->begin == field->end && spaced); /* brackets alone */
    if (field->end - field->begin >= 2 && *field->begin == '"' && field->end[-1] == '"') {
        field->begin++;
        field->end--;
    }
    return true;
}

uint32_t stp_bracket_groups(const char *begin, const char *end)
{
    uint32_t count = 0;
    bool closed = true;
    for (const char *at = begin; at < end; at++) {
        count += closed && stp_is_opening(*at);
        closed = stp_is_closing(*at) || (closed && !stp_is_opening(*at));
    }
    return count;
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* Whether three digits follow, and no fourth, and one precedes. */
static bool is_thousands_mark(stp_field field, const char *at)
{
    if (at == field.begin || field.end - at < 4 || !is_digit(at[-1]))
        return false;
    return is_digit(at[1]) && is_digit(at[2]) && is_digit(at[3]) &&
           (field.end - at == 4 || !is_digit(at[4]));
}

bool stp_field_number(stp_separator separator, stp_field field, double *value)
{
    const size_t length = (size_t)(field.end - field.begin);
    if (length == 0)
        return false;
    if (stp_number_parse(field.begin, field.end, value))
        return true;
    char text[STP_FIELD_CHARS_MAX];
    size_t used = 0;
    for (const char *at = field.begin; at < field.end; at++) {
        const ptrdiff_t left = field.end - at;
        if (used == sizeof text)
            return false;
        if (*at == '\'' && is_thousands_mark(field, at))
            continue;
        if (*at == ',' && left > 1 && separator != STP_SEPARATOR_COMMA && !memchr(text, '.', used))
            text[used++] = '.';
        else if ((*at | 32) == 'd' && left > 2 && (at[1] == '+' || at[1] == '-'))
            text[used++] = 'e';
        else
            text[used++] = *at;
    }
    return stp_number_parse(text, text + used, value);
}

bool stp_field_is_missing(stp_field field)
{
    static const char *const words[] = {"",       "na",      "n/a", "null", "none",
                                        "nodata", "no data", "bad", "-",    "***"};
    const size_t length = (size_t)(field.end - field.begin);
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strlen(words[i]) == length && strncasecmp(words[i], field.begin, length) == 0)
            return true;
    return false;
}

static int hex_digit(char c)
{
    const char *digits = "0123456789abcdef", lower = (char)(c >= 'A' && c <= 'F' ? c + 32 : c);
    const char *at = lower != '\0' ? strchr(digits, lower) : NULL;
    return at ? (int)(at - digits) : -1;
}

/* All of it, 6 or 8 digits. */
static bool read_hex(const char *begin, const char *end, uint32_t *value)
{
    *value = 0;
    for (const char *at = begin; at < end; at++) {
        if (hex_digit(*at) < 0)
            return false;
        *value = *value << 4 | (uint32_t)hex_digit(*at);
    }
    return end - begin == 6 || end - begin == 8;
}

/* How many characters tell that hexadecimal digits follow. */
static int hex_sign(stp_field field)
{
    const ptrdiff_t length = field.end - field.begin;
    if (length > 1 && *field.begin == '#')
        return 1;
    return length > 2 && *field.begin == '0' && (field.begin[1] | 32) == 'x' ? 2 : 0;
}

bool stp_field_is_hex(stp_field field, bool bare)
{
    uint32_t value;
    const int sign = hex_sign(field);
    return (sign > 0 || bare) && read_hex(field.begin + sign, field.end, &value);
}

bool stp_field_colour(stp_separator separator, stp_field field, bool hex, double *value)
{
    const int sign = hex_sign(field);
    uint32_t bits;
    double number = NAN;
    const bool is_number = stp_field_number(separator, field, &number);
    if (field.begin == field.end || (is_number && isnan(number))) {
        *value = 0.0;
        return true;
    }
    if (hex || sign > 0) {
        if (!read_hex(field.begin + sign, field.end, &bits))
            return false;
        const bool alpha_last = sign < 2 && field.end - field.begin - sign == 8;
        *value = (alpha_last ? bits >> 8 : bits) & 0xFFFFFFu;
        return true;
    }
    if (!is_number || !(fabs(number) <= FLT_MAX))
        return false;
    if (floor(number) != number || fabs(number) >= 0x1p32) {
        const float packed = (float)number;
        memcpy(&bits, &packed, sizeof bits);
    } else {
        bits = (uint32_t)(int64_t)number;
    }
    *value = bits & 0xFFFFFFu;
    return true;
}

stp_field_count stp_fields_count(stp_separator separator, const char *begin, const char *end)
{
    stp_field_count count = {0, 0};
    stp_field field;
    double value;
    for (const char *at = begin; stp_field_next(separator, &at, end, &field);) {
        count.fields++;
        count.numbers += stp_field_number(separator, field, &value);
    }
    return count;
}

stp_separator stp_separator_find(const char *begin, const char *end)
{
    stp_separator best = STP_SEPARATOR_SPACE;
    stp_field_count most = {0, 0};
    for (int i = 0; i < STP_SEPARATOR_COUNT; i++) {
        const stp_field_count count = stp_fields_count((stp_separator)i, begin, end);
        if (count.numbers > most.numbers ||
            (count.numbers == most.numbers && count.numbers > 0 && count.fields < most.fields)) {
            best = (stp_separator)i;
            most = count;
        }
    }
    return best;
}
