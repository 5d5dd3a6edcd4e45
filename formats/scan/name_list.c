/* A list of fields that are not read, as one line. */
#include "formats/scan/name_list.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define SEPARATOR ", "
#define ELLIPSIS ", ..."

static bool holds(const stp_name_list *list, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = list->text; (at = strstr(at, name)) != NULL; at += length)
        if ((at == list->text || at[-1] == ' ') && (at[length] == ',' || at[length] == '\0'))
            return true;
    return false;
}

void stp_name_list_add(stp_name_list *list, const char *name)
{
    const size_t used = strlen(list->text), ellipsis = strlen(ELLIPSIS);
    char *end = list->text + used;
    if (name[0] == '\0' || holds(list, name) ||
        (used >= ellipsis && strcmp(end - ellipsis, ELLIPSIS) == 0))
        return;
    if (used + strlen(SEPARATOR) + strlen(name) + ellipsis < sizeof list->text)
        snprintf(end, sizeof list->text - used, "%s%s", used > 0 ? SEPARATOR : "", name);
    else
        memcpy(end, ELLIPSIS, ellipsis + 1);
}
