/* Tests conditions on fields: truth tables, missing values, and what is no condition. */
#include "formats/attribute/where.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/support/check.h"

#include <math.h>

/* A point whose fields a, b, c and "x y" are 1, 2, NaN and -0.5. */
static bool holds(const char *text)
{
    static const struct {
        const char *name;
        double value;
    } fields[] = {{"a", 1.0}, {"b", 2.0}, {"c", NAN}, {"x y", -0.5}};
    stp_where w;
    double values[STP_WHERE_NAMES];
    check_ok(stp_where_parse(&w, text, err));
    for (unsigned n = 0; n < w.name_count; n++) {
        size_t f = 0;
        while (strcmp(fields[f].name, w.names[n]) != 0)
            assert_true(++f < sizeof fields / sizeof *fields);
        values[n] = fields[f].value;
    }
    return stp_where_holds(&w, values);
}

static void truths(void **state)
{
    static const char *const hold[] = {
        "a==1",
        " a == 1 ",
        "1==a",
        "a!=b",
        "a<b",
        "a<=1&&b>=2",
        "b>a",
        "2>1.5e0",
        "!a==2",
        "!(a==2||b==3)",
        "a==2&&a==1||b==2", /* && binds closer */
        "b==2||a==1&&a==2",
        "(b==3||a==1)&&b==2",
        "\"x y\"==-0.5",
        "a == a && b == b && !(c == c)",
        "!!a==1",
    };
    static const char *const not_hold[] = {"a==2", "a!=1", "b<a", "b<=1", "a>1", "!(a==1)",
                                           "(b==2||a==1)&&b==3", "a==1&&b==3",
                                           /* a missing value */
                                           "c==c", "c!=c", "c!=1", "c<1", "c>1", "c<=1", "1>=c"};
    (void)state;
    for (size_t i = 0; i < sizeof hold / sizeof *hold; i++)
        if (!holds(hold[i]))
            fail_msg("%s does not hold", hold[i]);
    for (size_t i = 0; i < sizeof not_hold / sizeof *not_hold; i++)
        if (holds(not_hold[i]))
            fail_msg("%s holds", not_hold[i]);
}

static void refusals(void **state)
{
    static const struct {
        const char *text, *said;
    } wrong[] = {{"", "a number or a name is expected at the end"},
                 {"a", "one of == != < <= > >= is expected at the end"},
                 {"a=1", "is expected at '=1'"},
                 {"a==", "a number or a name is expected at the end"},
                 {"a==1 b==2", "&& or || is expected at 'b==2'"},
                 {"a==1 &&", "a number or a name"},
                 {"a==1 & b==2", "&& or || is expected at '& b==2'"},
                 {"(a==1", ") is expected at the end"},
                 {"a==1)", "&& or || is expected at ')'"},
                 {"\"a==1", "a name that ends in \""},
                 {"\"\"==1", "a name is expected"},
                 {"a==1e999", "a number or a name"},
                 {"a==nan()", "&& or ||"},
                 {"é==1", "a number or a name"}};
    char text[4096] = "";
    size_t at;
    stp_where w;
    stp_error error;
    (void)state;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_int_equal(stp_where_parse(&w, wrong[i].text, &error), STP_INVALID_ARGUMENT);
        if (!strstr(error.message, wrong[i].said))
            fail_msg("%s: %s", wrong[i].text, error.message);
    }
    memset(text, '(', 1000);
    assert_int_equal(stp_where_parse(&w, text, &error), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "fewer brackets"));
    memset(text, '!', 1000);
    assert_int_equal(stp_where_parse(&w, text, &error), STP_INVALID_ARGUMENT);
    at = (size_t)sprintf(text, "a==0");
    for (int i = 0; i < 100; i++)
        at += (size_t)sprintf(text + at, "||a==0");
    assert_int_equal(stp_where_parse(&w, text, &error), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "too long"));
    at = (size_t)sprintf(text, "a0==0");
    for (int i = 1; i < 30; i++)
        at += (size_t)sprintf(text + at, "||a%d==a0", i);
    check_ok(stp_where_parse(&w, text, err));
    assert_int_equal(w.name_count, 30);
    at = (size_t)sprintf(text, "a0<b0");
    for (int i = 1; i < 20; i++)
        at += (size_t)sprintf(text + at, "||a%d<b%d", i, i);
    assert_int_equal(stp_where_parse(&w, text, &error), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "more than 32 fields"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(truths),
        cmocka_unit_test(refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
