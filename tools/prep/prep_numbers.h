/* Brings the attributes of several inputs to one list. Threads: one at a time. */
#ifndef STP_TOOLS_PREP_PREP_NUMBERS_H
#define STP_TOOLS_PREP_PREP_NUMBERS_H

#include "base/error.h"
#include "formats/attribute/attribute_list.h"

typedef struct prep_numbers {
    const char *wanted;         /* "all", "none" or NULL, or names with commas between them */
    stp_attribute_union joined; /* of the model, from the inputs with points */
    char left_out[320];         /* if none is wanted: names of the first input's that has any */
    uint8_t *packed; /* the numbers of the points read last, as the model's list has them */
    size_t capacity;
} prep_numbers;

/* True if attributes are wanted at all. */
bool prep_numbers_wanted(const prep_numbers *numbers);
/* Joins the attributes of an input with points into the list; extra may be NULL. An attribute that
 * an input lacks gets a number for "missing", and its type may widen. Errors: LIMIT (too many). */
stp_status prep_numbers_add(prep_numbers *numbers, const stp_attribute_list *extra,
                            const char *path, stp_error *err);
/* Notes the attributes of an input, of which none is wanted. */
void prep_numbers_leave_out(prep_numbers *numbers, const stp_attribute_list *extra);
/* Checks that each wanted name was found. Errors: INVALID_ARGUMENT, with the names there are. */
stp_status prep_numbers_check(const prep_numbers *numbers, stp_error *err);
/* Takes the numbers of `count` points of an input into numbers->packed. from NULL: it has none.
 * Errors: OUT_OF_MEMORY. */
stp_status prep_numbers_take(prep_numbers *numbers, const stp_attribute_list *extra,
                             const uint8_t *from, size_t count, stp_error *err);
void prep_numbers_clear(prep_numbers *numbers);

#endif
