/* Brings the attributes of several inputs to one list. */
#include "tools/prep/prep_numbers.h"

#include "base/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool prep_numbers_wanted(const prep_numbers *numbers)
{
    return numbers->wanted && strcmp(numbers->wanted, "none") != 0;
}

/* The next name of a list with commas; *text moves behind it. False at the end. */
static bool next_name(const char **text, const char **name, size_t *length)
{
    if (!*text || **text == '\0')
        return false;
    *name = *text;
    *length = strcspn(*text, ",");
    *text += *length + ((*text)[*length] == ',');
    return true;
}

static bool is_wanted(const prep_numbers *numbers, const char *attribute)
{
    const char *text = numbers->wanted, *name = NULL;
    size_t length = 0;
    if (strcmp(text, "all") == 0)
        return true;
    while (next_name(&text, &name, &length))
        if (strlen(attribute) == length && strncmp(attribute, name, length) == 0)
            return true;
    return false;
}

stp_status prep_numbers_add(prep_numbers *n, const stp_attribute_list *extra, const char *path,
                            stp_error *err)
{
    stp_attribute_list wanted = {.count = 0};
    for (uint32_t i = 0; extra && i < extra->count; i++)
        if (is_wanted(n, extra->items[i].name))
            wanted.items[wanted.count++] = extra->items[i];
    if (!stp_attribute_union_add(&n->joined, &wanted))
        return stp_error_set(err, STP_LIMIT,
                             "%s: with it the inputs have more than %u attributes: name those to "
                             "keep (--attributes)",
                             path, STP_ATTRIBUTES_LIMIT);
    return STP_OK;
}

void prep_numbers_leave_out(prep_numbers *n, const stp_attribute_list *extra)
{
    const size_t room = sizeof n->left_out;
    size_t at = 0;
    if (n->left_out[0] != '\0' || !extra)
        return;
    for (uint32_t i = 0; i < extra->count && at + STP_ATTRIBUTE_NAME_BYTES + 2 < room; i++)
        if (extra->items[i].coarse == STP_COARSE_NOT) /* the others are in the samples, coarsely */
            at += (size_t)snprintf(n->left_out + at, room - at, "%s%s", at > 0 ? ", " : "",
                                   extra->items[i].name);
}

stp_status prep_numbers_check(const prep_numbers *n, stp_error *err)
{
    const char *text = n->wanted, *name = NULL;
    size_t length = 0;
    char known[512] = "";
    if (!prep_numbers_wanted(n) || strcmp(text, "all") == 0)
        return STP_OK;
    while (next_name(&text, &name, &length)) {
        char own[STP_ATTRIBUTE_NAME_BYTES];
        snprintf(own, sizeof own, "%.*s", (int)length, name);
        if (stp_attribute_find(&n->joined.list, own) != UINT32_MAX)
            continue;
        for (uint32_t i = 0, at = 0; i < n->joined.list.count && at < sizeof known - 64; i++)
            at += (uint32_t)snprintf(known + at, sizeof known - at, "%s%s",
                                     i ? ", "
                                       : ": of those "
                                         "named, the inputs have ",
                                     n->joined.list.items[i].name);
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--attributes: no input has the attribute \"%s\"%s (all keeps "
                             "everything, none nothing)",
                             own, known);
    }
    return STP_OK;
}

stp_status prep_numbers_take(prep_numbers *n, const stp_attribute_list *extra, const uint8_t *from,
                             size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t bytes = stp_attribute_list_bytes(&n->joined.list);
    const size_t from_bytes = from ? stp_attribute_list_bytes(extra) : 0;
    uint8_t *to = NULL;
    STP_TRY(stp_grow(&n->packed, &n->capacity, count * bytes + 1, 1, "attributes", err));
    to = n->packed;
    for (uint32_t a = 0; a < n->joined.list.count; a++) {
        const stp_attribute *own = &n->joined.list.items[a];
        const uint32_t k = from ? stp_attribute_find(extra, own->name) : UINT32_MAX;
        const uint8_t *at = from;
        for (uint32_t i = 0; k != UINT32_MAX && i < k; i++)
            at += stp_attribute_bytes(extra->items[i].type);
        for (size_t i = 0; i < count; i++)
            stp_attribute_put(
                own->type,
                k == UINT32_MAX ? stp_attribute_missing(own)
                                : stp_attribute_union_word(
                                      own, &extra->items[k],
                                      stp_attribute_get(extra->items[k].type, at + i * from_bytes)),
                to + i * bytes);
        to += stp_attribute_bytes(own->type);
    }
done:
    return status;
}

void prep_numbers_clear(prep_numbers *n)
{
    free(n->packed);
    *n = (prep_numbers){0};
}
