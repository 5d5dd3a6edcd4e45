/* A text that grows to a bound; collects what a LAS file says of itself for stp_scan_note. */
#ifndef STP_FORMATS_SCAN_LAS_LAS_TEXT_H
#define STP_FORMATS_SCAN_LAS_LAS_TEXT_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>

/* Greatest length of a text. Longer texts are cut and end in "...". */
#define STP_LAS_TEXT_MAX ((size_t)1 << 20)

typedef struct stp_las_text {
    char *bytes; /* ends with a zero; NULL while empty */
    size_t length, capacity;
    bool full;
} stp_las_text;

/* Appends. Errors: OUT_OF_MEMORY. */
stp_status stp_las_text_add(stp_las_text *text, stp_error *err, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* Appends length bytes of a file, up to the first zero, as UTF-8. Control characters become spaces;
 * other bytes that are no UTF-8 become `?`. Errors: OUT_OF_MEMORY. */
stp_status stp_las_text_add_bytes(stp_las_text *text, const unsigned char *bytes, size_t length,
                                  stp_error *err);
/* Removes spaces at the end. */
void stp_las_text_trim(stp_las_text *text);
void stp_las_text_free(stp_las_text *text);

#endif
