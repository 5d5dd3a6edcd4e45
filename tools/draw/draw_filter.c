/* Parses clip box and classes of the command line. */
#include "tools/draw/draw_filter.h"

#include "runtime/class_legend.h"
#include "tools/cli/cli_value.h"

#include <stdlib.h>
#include <string.h>

stp_status draw_filter_clip(const char *text, const stp_dbox *model, stp_clip *out, stp_error *err)
{
    stp_dbox box;
    stp_status status = cli_value_box("--clip", text, model, &box, err);
    if (status == STP_OK)
        *out = (stp_clip){.enabled = true, .box = box};
    return status;
}

/* The class of a word in the list; -1 if there is none. */
static int class_of(const char *word, size_t length)
{
    char *end = NULL;
    if (length == 0 || strspn(word, "0123456789") < length)
        return stp_class_find(word, length);
    unsigned long number = strtoul(word, &end, 10);
    return number <= UINT8_MAX ? (int)number : -1;
}

stp_status draw_filter_classes(const char *option, const char *text, uint32_t out[8],
                               stp_error *err)
{
    uint32_t found[8] = {0};
    const char *word = text;
    for (bool more = true; more;) {
        size_t length = strcspn(word, ",");
        int id = class_of(word, length);
        if (id < 0)
            return stp_error_set(err, STP_INVALID_ARGUMENT,
                                 "%s %s: '%.*s' is no class: give numbers from 0 to 255 or names, "
                                 "like 2,building,high-vegetation",
                                 option, text, (int)length, word);
        found[id / 32] |= UINT32_C(1) << id % 32;
        more = word[length] == ',';
        word += length + 1;
    }
    memcpy(out, found, sizeof found);
    return STP_OK;
}
