/* Tests the values of the command line: which texts each kind accepts, and the distance between
 * words. */
#include "tools/cli/cli_value.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

typedef struct uint_case {
    const char *text;
    bool good;
    uint64_t value;
} uint_case;

static void check_uints(cli_kind kind, const uint_case *cases, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint64_t value = 77;
        bool given = false;
        const cli_option option = {"--x", 0, kind, &value, "N", "", &given};
        bool stored = cli_value_store(&option, cases[i].text);
        if (stored != cases[i].good || value != (stored ? cases[i].value : 77) || given != stored)
            fail_msg("'%s' gave %d, %llu", cases[i].text, stored, (unsigned long long)value);
    }
}

static void test_uint(void **state)
{
    (void)state;
    static const uint_case cases[] = {
        {"0", true, 0},
        {"12", true, 12},
        {"1e6", true, 1000000},
        {"4M", true, 4000000},
        {"4m", true, 4000000},
        {"1.5k", true, 1500},
        {"2G", true, 2000000000},
        {"18446744073709551615", true, UINT64_MAX},
        {"18446744073709551616", false, 0},
        {"1e30", false, 0},
        {"-1", false, 0},
        {"-0", false, 0},
        {"1.5", false, 0},
        {"", false, 0},
        {" 1", false, 0},
        {"1 ", false, 0},
        {"0x10", false, 0},
        {"4MB", false, 0},
        {"inf", false, 0},
        {"nan", false, 0},
        {"M", false, 0},
        {"1,5", false, 0},
    };
    check_uints(CLI_UINT, cases, sizeof cases / sizeof *cases);
}

static void test_bytes(void **state)
{
    (void)state;
    static const uint_case cases[] = {
        {"1024", true, 1024},
        {"256M", true, UINT64_C(256) << 20},
        {"1G", true, UINT64_C(1) << 30},
        {"1.5K", true, 1536},
        {"2T", true, UINT64_C(2) << 40},
        {"3MB", true, UINT64_C(3) << 20},
        {"3MiB", true, UINT64_C(3) << 20},
        {"10B", true, 10},
        {"1e9", true, 1000000000},
        {"1X", false, 0},
        {"9999999T", false, 0},
        {"-1G", false, 0},
    };
    check_uints(CLI_BYTES, cases, sizeof cases / sizeof *cases);
}

/* Each text must be refused and leave the value alone. */
static void check_refused(const cli_option *option, const char *const *texts, size_t count)
{
    double *value = option->target;
    *value = 7.0;
    for (size_t i = 0; i < count; i++) {
        assert_false(cli_value_store(option, texts[i]));
        assert_true(*value == 7.0);
    }
}

static void test_number(void **state)
{
    (void)state;
    static const char *const bad[] = {"", "nan", "inf", "1e999", "1,5", "1.5x", " 1", "0x1p3", "-"};
    double value = 7.0;
    const cli_option option = {"--x", 0, CLI_NUMBER, &value, "N", "", NULL};
    check_refused(&option, bad, sizeof bad / sizeof *bad);
    assert_true(cli_value_store(&option, "-2.5e-3"));
    assert_true(value == -2.5e-3);
    assert_true(cli_value_store(&option, ".5"));
    assert_true(value == 0.5);
}

static void test_seconds(void **state)
{
    (void)state;
    static const char *const bad[] = {"", "-1", "86400.5", "1e9", "inf", "1s"};
    double value = 7.0;
    const cli_option option = {"--x", 0, CLI_SECONDS, &value, "S", "", NULL};
    check_refused(&option, bad, sizeof bad / sizeof *bad);
    assert_true(cli_value_store(&option, "86400"));
    assert_true(value == CLI_SECONDS_MOST);
    assert_true(cli_value_store(&option, "0"));
    assert_true(value == 0.0);
}

static void test_vec3(void **state)
{
    (void)state;
    static const char *const bad[] = {"",     "1",    "1,2",   "1,2,3,4",
                                      "1,2,", ",1,2", "1 2 3", "1,2,nan"};
    double v[3] = {7, 7, 7};
    const cli_option option = {"--eye", 0, CLI_VEC3, v, "x,y,z", "", NULL};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_false(cli_value_store(&option, bad[i]));
        assert_true(v[0] == 7.0 && v[1] == 7.0 && v[2] == 7.0);
    }
    assert_true(cli_value_store(&option, "1,-2.5,3e2"));
    assert_true(v[0] == 1.0 && v[1] == -2.5 && v[2] == 300.0);
}

static void test_extent(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "",        "512",     "0x5",   "5x0",  "-1x5",
        "16385x1", "1x16385", "5x5x5", "5 x5", "99999999999999999999x1"};
    int v[2] = {7, 7};
    const cli_option option = {"--size", 0, CLI_EXTENT, v, "WxH", "", NULL};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_false(cli_value_store(&option, bad[i]));
        assert_true(v[0] == 7 && v[1] == 7);
    }
    assert_true(cli_value_store(&option, "1024x768"));
    assert_true(v[0] == 1024 && v[1] == 768);
    assert_true(cli_value_store(&option, "16384X1"));
    assert_true(v[0] == 16384 && v[1] == 1);
}

static void test_choice_and_string(void **state)
{
    (void)state;
    int choice = 7;
    const char *text = NULL;
    const cli_option option = {"--lod", 0, CLI_CHOICE, &choice, "geometry|cpu|full", "", NULL};
    const cli_option named = {"-o", 'o', CLI_STRING, &text, "F", "", NULL};
    assert_true(cli_value_store(&option, "geometry"));
    assert_int_equal(choice, 0);
    assert_true(cli_value_store(&option, "full"));
    assert_int_equal(choice, 2);
    assert_false(cli_value_store(&option, "ful"));
    assert_false(cli_value_store(&option, "geometry|cpu"));
    assert_false(cli_value_store(&option, ""));
    assert_int_equal(choice, 2);
    assert_false(cli_value_store(&named, ""));
    assert_true(cli_value_store(&named, "a b"));
    assert_string_equal(text, "a b");
}

static void test_distance(void **state)
{
    (void)state;
    assert_int_equal(cli_word_distance("", ""), 0);
    assert_int_equal(cli_word_distance("prep", "prep"), 0);
    assert_int_equal(cli_word_distance("", "prep"), 4);
    assert_int_equal(cli_word_distance("prpe", "prep"), 1);
    assert_int_equal(cli_word_distance("kitten", "sitting"), 3);
    assert_int_equal(cli_word_distance("expotr", "export"), 1);
    char far[200];
    memset(far, 'a', sizeof far - 1);
    far[sizeof far - 1] = '\0';
    assert_true(cli_word_distance(far, "prep") > 60);
    assert_true(cli_word_near("--treshold", 1));
    assert_false(cli_word_near("--xyz", 3));
    assert_false(cli_word_near("x", 1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_uint),
        cmocka_unit_test(test_bytes),
        cmocka_unit_test(test_number),
        cmocka_unit_test(test_vec3),
        cmocka_unit_test(test_seconds),
        cmocka_unit_test(test_extent),
        cmocka_unit_test(test_choice_and_string),
        cmocka_unit_test(test_distance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
