/* Reads the values of PLY records one after the other, in any encoding.
 *
 * ASCII: a record is a line. Empty lines are skipped. A line with fewer or more values than the
 * header declares is a fault, because reading on would shift every later value. */
#ifndef STP_FORMATS_SCAN_PLY_PLY_VALUES_H
#define STP_FORMATS_SCAN_PLY_PLY_VALUES_H

#include "base/error.h"
#include "formats/scan/ply/ply_header.h"
#include "formats/scan/source.h"

#include <stddef.h>
#include <stdint.h>

typedef struct stp_ply_cursor {
    stp_source *source;
    stp_ply_encoding encoding;
    const stp_ply_element *element; /* the element that is being read; for messages */
    uint64_t index;                 /* of the record that is being read */
    const char *at, *end;           /* ASCII: rest of the record's line */
} stp_ply_cursor;

/* Decodes count values that lie stride bytes apart. Allocates nothing. */
void stp_ply_load_column(stp_ply_type type, stp_ply_encoding encoding, const unsigned char *bytes,
                         size_t stride, size_t count, double *out);

/* Returns CORRUPT. The message says which record of how many ends early, and where. */
stp_status stp_ply_cut(const stp_ply_cursor *cursor, stp_error *err);

/* To read a record, call begin, then next for every value, then end. Errors: IO, CORRUPT, LIMIT,
 * OUT_OF_MEMORY. */
stp_status stp_ply_record_begin(stp_ply_cursor *cursor, stp_error *err);
stp_status stp_ply_next_value(stp_ply_cursor *cursor, stp_ply_type type, double *value,
                              stp_error *err);
/* Reads the length of a list and checks it against what the file can still hold. */
stp_status stp_ply_next_length(stp_ply_cursor *cursor, const stp_ply_property *list,
                               uint64_t *length, stp_error *err);
/* Skips a property of the record. */
stp_status stp_ply_skip_property(stp_ply_cursor *cursor, const stp_ply_property *property,
                                 stp_error *err);
stp_status stp_ply_record_end(stp_ply_cursor *cursor, stp_error *err);

/* Skips all records of an element, from its first. */
stp_status stp_ply_skip_element(stp_ply_cursor *cursor, const stp_ply_header *header,
                                const stp_ply_element *element, stp_error *err);

#endif
