/* Parses decimal numbers in text without a locale. */
#include "formats/scan/number.h"

#include <locale.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* A longer token is no number that anyone wrote on purpose. */
#define STP_NUMBER_CHARS_MAX 400

/* If mantissa and exponent are below these limits, both operands are exact doubles, so one
 * operation rounds correctly (Clinger 1990). */
#define STP_EXACT_MANTISSA ((uint64_t)1 << 53)
#define STP_EXACT_EXPONENT 22

/* This many digits always fit into 64 bits, and 5 to this power fits into 63. */
#define STP_WIDE_DIGITS 19
#define STP_WIDE_EXPONENT 27

static const double powers_of_ten[STP_EXACT_EXPONENT + 1] = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

static const uint64_t powers_of_five[STP_WIDE_EXPONENT + 1] = {
    1u,
    5u,
    25u,
    125u,
    625u,
    3125u,
    15625u,
    78125u,
    390625u,
    1953125u,
    9765625u,
    48828125u,
    244140625u,
    1220703125u,
    6103515625u,
    30517578125u,
    152587890625u,
    762939453125u,
    3814697265625u,
    19073486328125u,
    95367431640625u,
    476837158203125u,
    2384185791015625u,
    11920928955078125u,
    59604644775390625u,
    298023223876953125u,
    1490116119384765625u,
    7450580596923828125u,
};

/* mantissa * 10^exponent; exact: no digit was lost. */
typedef struct decimal {
    uint64_t mantissa;
    int exponent;
    bool exact;
} decimal;

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* nan, inf and the forms that Windows' printf writes. */
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

/* Parses the rare cases (many digits, large exponents) with the C library, in the C locale. */
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

/* The mantissa wraps around beyond 19 significant digits; the caller detects that. */
static const char *scan_digits(const char *at, const char *end, uint64_t *mantissa)
{
    uint64_t value = *mantissa;
    for (; at < end && is_digit(*at); at++)
        value = value * 10 + (uint64_t)(*at - '0');
    *mantissa = value;
    return at;
}

/* True if [at, end), digits and at most one point, has no more significant digits than fit. */
static bool digits_fit(const char *at, const char *end)
{
    int count = 0;
    for (; at < end; at++)
        count += is_digit(*at) && (count > 0 || *at != '0');
    return count <= STP_WIDE_DIGITS;
}

/* Scans digits, at most one point and an exponent. Returns the end of the number, NULL if there is
 * none. */
static const char *scan_decimal(const char *begin, const char *end, decimal *out)
{
    uint64_t mantissa = 0;
    ptrdiff_t fraction = 0;
    const char *at = scan_digits(begin, end, &mantissa);
    ptrdiff_t digits = at - begin;
    if (at < end && *at == '.') {
        const char *point = at + 1;
        at = scan_digits(point, end, &mantissa);
        fraction = at - point;
        digits += fraction;
    }
    if (digits == 0 || digits > STP_NUMBER_CHARS_MAX)
        return NULL;
    *out = (decimal){mantissa, -(int)fraction, digits <= STP_WIDE_DIGITS || digits_fit(begin, at)};
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
        out->exponent += negative ? -value : value;
    }
    return at;
}

/* value * 2^exponent for normal numbers. */
static double scale_by_two(double value, int exponent)
{
    const uint64_t bits = (uint64_t)(exponent + 1023) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return value * power;
}

/* Composes numbers with up to 19 digits and 27 places either way in integers. Multiplies or divides
 * the mantissa by a power of five, to at least 63 bits; the last bit says whether a nonzero rest
 * follows. The only rounding is the conversion to double. mantissa is not 0. */
static double compose_wide(uint64_t mantissa, int exponent)
{
    const uint64_t five = powers_of_five[exponent < 0 ? -exponent : exponent];
    const int shift = __builtin_clzll(mantissa), five_shift = __builtin_clzll(five);
    const uint64_t a = mantissa << shift, b = five << five_shift;
    if (exponent < 0) {
        const unsigned __int128 dividend = (unsigned __int128)a << 63;
        const uint64_t quotient = (uint64_t)(dividend / b);
        const uint64_t rest = (uint64_t)(dividend - (unsigned __int128)quotient * b);
        return scale_by_two((double)(quotient | (rest > 0)), exponent + five_shift - shift - 63);
    }
    const unsigned __int128 product = (unsigned __int128)a * b;
    const uint64_t high = (uint64_t)(product >> 64);
    return scale_by_two((double)(high | ((uint64_t)product > 0)),
                        exponent + 64 - five_shift - shift);
}

const char *stp_number_scan(const char *begin, const char *end, double *value)
{
    decimal d;
    double result;
    const bool negative = begin < end && *begin == '-';
    const char *digits = begin + (begin < end && (*begin == '-' || *begin == '+'));
    const char *stop = scan_decimal(digits, end, &d);
    if (!stop)
        return NULL;
    const int distance = d.exponent < 0 ? -d.exponent : d.exponent;
    if (d.exact && d.mantissa <= STP_EXACT_MANTISSA && distance <= STP_EXACT_EXPONENT) {
        result = d.exponent < 0 ? (double)d.mantissa / powers_of_ten[distance]
                                : (double)d.mantissa * powers_of_ten[distance];
    } else if (d.exact && d.mantissa > 0 && distance <= STP_WIDE_EXPONENT) {
        result = compose_wide(d.mantissa, d.exponent);
    } else {
        if (stop - digits > STP_NUMBER_CHARS_MAX)
            return NULL;
        result = parse_slow(digits, (size_t)(stop - digits));
    }
    *value = negative ? -result : result;
    return stop;
}

bool stp_number_parse(const char *begin, const char *end, double *value)
{
    if (end - begin > STP_NUMBER_CHARS_MAX)
        return false;
    double result = 0.0;
    if (stp_number_scan(begin, end, &result) == end) {
        *value = result;
        return begin < end;
    }
    return parse_special(begin, end, value);
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
