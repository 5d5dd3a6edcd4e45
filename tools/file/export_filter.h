/* Chooses the points that export writes: by a condition on their fields, by a box, and by level.
 * Threads: one at a time. */
#ifndef STP_TOOLS_FILE_EXPORT_FILTER_H
#define STP_TOOLS_FILE_EXPORT_FILTER_H

#include "formats/chunk/attribute/sample_fields.h"
#include "tools/file/export_numbers.h"

/* The options of the command line; NULL: all points. */
typedef struct export_choice {
    const char *where, *clip;
    int level;
} export_choice;

typedef struct export_filter {
    bool conditional, clipped;
    stp_condition condition;
    double intensity_step; /* of the samples */
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
/* position: of the sample. packed: its attributes; NULL: none. */
bool export_filter_takes(const export_filter *filter, const stp_sample *sample, stp_dvec3 position,
                         const uint8_t *packed);
/* Whether a chunk with this box may have points that are taken. */
static inline bool export_filter_meets(const export_filter *filter, const stp_dbox *box)
{
    return !filter->clipped || stp_dbox_meet(&filter->clip, box);
}

#endif
