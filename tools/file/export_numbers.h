/* The attributes of a chunk's points, as writers of points take them. Threads: one at a time. */
#ifndef STP_TOOLS_FILE_EXPORT_NUMBERS_H
#define STP_TOOLS_FILE_EXPORT_NUMBERS_H

#include "formats/chunk/attribute/attribute_file.h"

typedef struct export_numbers {
    stp_attribute_file *file;
    const stp_attribute_list *list; /* NULL: the file has none */
    uint8_t *packed;                /* by sample of the level of the chunk read last */
    size_t capacity, stride;
} export_numbers;

/* Errors: those of stp_attribute_file_open. Clear *out also after a failure. */
stp_status export_numbers_open(export_numbers *out, stp_chunk_file *file, stp_error *err);
/* Reads all attributes of a level of a chunk. Errors: those of stp_attribute_file_read. */
stp_status export_numbers_read(export_numbers *numbers, const stp_chunk *chunk, int level,
                               stp_error *err);
void export_numbers_clear(export_numbers *numbers);

#endif
