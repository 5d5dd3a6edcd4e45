/* Tests the list of fields that are not read: each name once, and a clean end if the list is
 * full. */
#include "formats/scan/name_list.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void names_once(void **state)
{
    (void)state;
    static const char *const names[] = {"ring", "t",    "ring", "time", "",
                                        "tim",  "ring", "im",   "time"};
    stp_name_list list = {{0}};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        stp_name_list_add(&list, names[i]);
    assert_string_equal(list.text, "ring, t, time, tim, im");
}

static void full_list(void **state)
{
    (void)state;
    stp_name_list *list = calloc(1, sizeof *list); /* exact size: a sanitizer sees its end */
    char name[80];
    assert_non_null(list);
    for (int i = 0; i < 1000; i++) {
        snprintf(name, sizeof name, "field%04d", i);
        stp_name_list_add(list, name);
    }
    const size_t length = strlen(list->text);
    assert_true(length < sizeof list->text && length > sizeof list->text - 30);
    assert_string_equal(list->text + length - 5, ", ...");
    assert_memory_equal(list->text, "field0000, field0001, ", 22);
    char *huge = malloc(10000);
    assert_non_null(huge);
    memset(huge, 'x', 9999);
    huge[9999] = '\0';
    *list = (stp_name_list){{0}};
    stp_name_list_add(list, "a");
    stp_name_list_add(list, huge);
    stp_name_list_add(list, "b");
    assert_string_equal(list->text, "a, ...");
    free(huge);
    free(list);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(names_once), cmocka_unit_test(full_list)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
