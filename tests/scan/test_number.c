/* Tests numbers in text against the C library's, to the last bit. */
#include "formats/scan/number.h"

#include "base/random.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t bits_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static void check(const char *text)
{
    double value = 0.0;
    const double expected = strtod(text, NULL);
    if (!stp_number_parse(text, text + strlen(text), &value) || bits_of(value) != bits_of(expected))
        fail_msg("%s: %.17g, expected %.17g", text, value, expected);
}

/* Whole numbers of 1 to 20 digits with any power of ten, and doubles printed in several ways. */
static void as_the_c_library(void **state)
{
    (void)state;
    char text[512];
    for (uint64_t i = 0; i < 400000; i++) {
        const uint64_t random = stp_random_u64(1, i);
        const uint64_t whole = stp_random_u64(2, i) >> random % 64;
        const int places = (int)(random >> 20) % 22;
        snprintf(text, sizeof text, "%llue%d", (unsigned long long)whole,
                 (int)(random >> 30) % 80 - 40);
        check(text);
        snprintf(text, sizeof text, "%.*f", places, (double)(int64_t)whole * 1e-9);
        check(text);
        snprintf(text, sizeof text, "%.*e", places, (double)whole * 1e-19);
        check(text);
    }
}

/* Numbers halfway between two doubles, and numbers just beside the middle. */
static void ties(void **state)
{
    (void)state;
    const char *const texts[] = {
        "9007199254740993",
        "9007199254740992.999",
        "9007199254740993.001",
        "9007199254740995",
        "18014398509481986",
        "18014398509481990",
        "9007199254740993e22",
        "9007199254740993e-22",
        "1152921504606846977",
        "5000000000000000000e-27",
        "9999999999999999999",
        "9999999999999999999e27",
        "9999999999999999999e-27",
        "18446744073709551615",
        "18446744073709551616",
        "0.1",
        "-0.0",
        "0e999",
        "1e308",
        "1e309",
        "4.9e-324",
        "1e-400",
        "2.2250738585072014e-308",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        check(texts[i]);
}

/* Zeros before and after the significant digits do not count as digits. */
static void many_digits(void **state)
{
    (void)state;
    check("0000000000000000000000000000000001.5");
    check("0.000000000000000000000000000000000012345");
    check("1.00000000000000000000000000000000000");
    check("123456789012345678901234567890.123456789012345678901234567890");
    check("0.1000000000000000055511151231257827021181583404541015625");
}

static void specials(void **state)
{
    (void)state;
    double value = 0.0;
    assert_true(stp_number_parse("nan", (const char *)"nan" + 3, &value) && isnan(value));
    check("inf");
    check("-inf");
    const char *qnan = "1.#QNAN";
    assert_true(stp_number_parse(qnan, qnan + 7, &value) && isnan(value));
    const char *infinite = "-1.#INF";
    assert_true(stp_number_parse(infinite, infinite + 7, &value) && isinf(value) && value < 0.0);
}

static void no_numbers(void **state)
{
    (void)state;
    const char *const texts[] = {"",    ".",     "-",   "+",  "e5", "1e",  "1e+",  "0x10",
                                 "1,5", "1.2.3", "--1", " 1", "1 ", "1d5", "1_000"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        double value = 7.0;
        assert_false(stp_number_parse(texts[i], texts[i] + strlen(texts[i]), &value));
        assert_true(value == 7.0);
    }
    char long_number[402];
    memset(long_number, '1', sizeof long_number);
    double value;
    assert_true(stp_number_parse(long_number, long_number + 400, &value));
    assert_false(stp_number_parse(long_number, long_number + 401, &value));
}

/* stp_number_scan must report where a number ends and must not read behind the given end. */
static void scans(void **state)
{
    (void)state;
    const char *text = "-12.5e1,3";
    double value = 0.0;
    assert_ptr_equal(stp_number_scan(text, text + 9, &value), text + 7);
    assert_true(value == -125.0);
    assert_ptr_equal(stp_number_scan(text, text + 3, &value), text + 3);
    assert_true(value == -12.0);
    assert_ptr_equal(stp_number_scan(text, text + 4, &value), text + 4);
    assert_null(stp_number_scan(text, text + 6, &value));
    assert_null(stp_number_scan(text + 7, text + 9, &value));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_the_c_library), cmocka_unit_test(ties),
        cmocka_unit_test(many_digits),      cmocka_unit_test(specials),
        cmocka_unit_test(no_numbers),       cmocka_unit_test(scans),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
