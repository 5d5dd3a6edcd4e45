/* Chooses the points that export writes: by a condition on their fields, by a box, and by level.
 * Threads: one at a time. */
#ifndef STP_TOOLS_FILE_EXPORT_FILTER_H
#define STP_TOOLS_FILE_EXPORT_FILTER_H

#include "formats/scan/scan.h"
#include "tools/file/export_numbers.h"
#include "tools/file/where.h"

/* The options of the command line; NULL: all points. */
typedef struct export_choice {
    const char *where, *clip;
    int level;
} export_choice;

/* Where the value of a name comes from. */
typedef struct export_field {
    const stp_attribute *attribute; /* or NULL: */
    int own;                        /* one of the fields that every point has */
    size_t at;                      /* of the attribute, in a packed point */
} export_field;

typedef struct export_filter {
    bool conditional, clipped;
    where condition;
    export_field fields[WHERE_NAMES]; /* by name of the condition */
    stp_dbox clip;
} export_filter;

/* numbers: open. Errors: INVALID_ARGUMENT (the condition, a name that the model has not, the box,
 * or one that holds nothing of the model), UNSUPPORTED (of lines and triangles all is written). */
stp_status export_filter_make(export_filter *out, const export_choice *choice,
                              const stp_chunk_file *file, const export_numbers *numbers,
                              stp_error *err);
/* Whether any points may be left out. */
static inline bool export_filter_chooses(const export_filter *filter)
{
    return filter->conditional || filter->clipped;
}
/* packed: the point's attributes; NULL: none. */
bool export_filter_takes(const export_filter *filter, const stp_point *point,
                         const uint8_t *packed);
/* Whether a chunk with this box may have points that are taken. */
static inline bool export_filter_meets(const export_filter *filter, const stp_dbox *box)
{
    return !filter->clipped || stp_dbox_meet(&filter->clip, box);
}

#endif
