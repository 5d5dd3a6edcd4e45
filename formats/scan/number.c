/* Decimal numbers out of text, without a locale. */
#include "formats/scan/number.h"

#include <locale.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Longer tokens than this are no number that anyone wrote on purpose. */
#define STP_NUMBER_CHARS_MAX 400

/* Below these both operands are exact doubles, so one operation rounds correctly (Clinger 1990). */
#define STP_EXACT_MANTISSA ((uint64_t)1 << 53)
#define STP_EXACT_EXPONENT 22

static const double powers_of_ten[STP_EXACT_EXPONENT + 1] = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* nan, inf and what Windows' printf makes of them. */
static bool parse_special(const char *begin, const char *end, double *value)
{
    bool negative = begin < end && *begin == '-';
    if (begin < end && (*begin == '-' || *begin == '+'))
        begin++;
    size_t length = (size_t)(end - begin);
    if ((length == 3 && strncasecmp(begin, "inf", 3) == 0) ||
        (length == 8 && strncasecmp(begin, "infinity", 8) == 0) ||
        (length >= 6 && strncasecmp(begin, "1.#INF", 6) == 0)) {
        *value = negative ? -INFINITY : INFINITY;
        return true;
    }
    if ((length == 3 && strncasecmp(begin, "nan", 3) == 0) ||
        (length > 4 && strncasecmp(begin, "nan(", 4) == 0 && end[-1] == ')') ||
        (length >= 5 && strncasecmp(begin, "1.#", 3) == 0 && strchr("QSIqsi", begin[3]))) {
        *value = NAN;
        return true;
    }
    return false;
}

/* The rare cases (many digits, large exponents) by the C library, in the C locale. */
static double parse_slow(const char *begin, size_t length)
{
    char text[STP_NUMBER_CHARS_MAX + 1];
    memcpy(text, begin, length);
    text[length] = '\0';
    locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    double value = c_locale ? strtod_l(text, NULL, c_locale) : strtod(text, NULL);
    if (c_locale)
        freelocale(c_locale);
    return value;
}

/* Digits, at most one point, an exponent. Gives mantissa * 10^exponent; exact says that no digit
 * was lost. Returns where the number ends, NULL if it is none. */
static const char *scan_decimal(const char *at, const char *end, uint64_t *mantissa, int *exponent,
                                bool *exact)
{
    bool any = false, point = false;
    *mantissa = 0;
    *exponent = 0;
    *exact = true;
    for (; at < end && (is_digit(*at) || (*at == '.' && !point)); at++) {
        if (*at == '.') {
            point = true;
            continue;
        }
        any = true;
        if (*mantissa < STP_EXACT_MANTISSA / 10)
            *mantissa = *mantissa * 10 + (uint64_t)(*at - '0');
        else
            *exact = false;
        *exponent -= point ? 1 : 0;
    }
    if (!any)
        return NULL;
    if (at < end && (*at == 'e' || *at == 'E')) {
        at++;
        bool negative = at < end && *at == '-';
        if (at < end && (*at == '-' || *at == '+'))
            at++;
        if (at == end || !is_digit(*at))
            return NULL;
        int value = 0;
        for (; at < end && is_digit(*at); at++)
            value = value < 100000 ? value * 10 + (*at - '0') : value;
        *exponent += negative ? -value : value;
    }
    return at;
}

bool stp_number_parse(const char *begin, const char *end, double *value)
{
    const char *at = begin;
    uint64_t mantissa;
    int exponent;
    bool exact;
    if (end - begin > STP_NUMBER_CHARS_MAX)
        return false;
    bool negative = at < end && *at == '-';
    if (at < end && (*at == '-' || *at == '+'))
        at++;
    if (scan_decimal(at, end, &mantissa, &exponent, &exact) != end)
        return parse_special(begin, end, value);
    if (exact && exponent >= -STP_EXACT_EXPONENT && exponent <= STP_EXACT_EXPONENT) {
        double result = exponent < 0 ? (double)mantissa / powers_of_ten[-exponent]
                                     : (double)mantissa * powers_of_ten[exponent];
        *value = negative ? -result : result;
        return true;
    }
    *value = parse_slow(begin, (size_t)(end - begin));
    return true;
}

bool stp_number_parse_u64(const char *begin, const char *end, uint64_t *value)
{
    uint64_t result = 0;
    if (begin == end)
        return false;
    for (; begin < end; begin++) {
        if (!is_digit(*begin) || __builtin_mul_overflow(result, (uint64_t)10, &result) ||
            __builtin_add_overflow(result, (uint64_t)(*begin - '0'), &result))
            return false;
    }
    *value = result;
    return true;
}
