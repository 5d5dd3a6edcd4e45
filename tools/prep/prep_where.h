/* Stores only the points that fulfil a condition (--where): rejects the others when they are read.
 * Threads: one at a time. */
#ifndef STP_TOOLS_PREP_PREP_WHERE_H
#define STP_TOOLS_PREP_PREP_WHERE_H

#include "formats/attribute/attribute_list.h"
#include "formats/attribute/condition.h"
#include "formats/scan/scan.h"
#include "tools/cli/cli.h"

/* Zero takes all points. */
typedef struct prep_where {
    const char *text; /* NULL: no condition */
    stp_where where;
    uint32_t fields;            /* that any input has: a bit for each stp_point_field */
    stp_attribute_union joined; /* attributes of all inputs with points */
    stp_condition condition;    /* bound to the scan that is read */
} prep_where;

/* The option --where. */
cli_option prep_where_option(const char **condition);

/* text: borrowed; NULL takes all points. Errors: INVALID_ARGUMENT (what was expected, and where).
 */
stp_status prep_where_parse(prep_where *w, const char *text, stp_error *err);
/* Takes note of what the points of an input have. Errors: LIMIT (too many attributes). */
stp_status prep_where_add(prep_where *w, const stp_scan_info *info, const char *path,
                          stp_error *err);
/* Checks that some input has each name. Call it after the last input. Errors: INVALID_ARGUMENT,
 * with the names there are. */
stp_status prep_where_check(prep_where *w, stp_error *err);
/* Begins a scan. */
void prep_where_open(prep_where *w, const stp_scan_info *info);
/* Rejects points of that scan. packed: their attributes; NULL: it has none. */
void prep_where_reject(const prep_where *w, const stp_scan_info *info, const uint8_t *packed,
                       stp_point *points, size_t count);

#endif
