/* Encodes the numbers of all attributes of a chunk. Threads: any. */
#ifndef STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_ENCODE_H
#define STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_ENCODE_H

#include "formats/chunk/attribute/attribute_order.h"
#include "formats/chunk/attribute/attribute_table.h"

/* What a sample says of a number: of colours and intensities, else 0. */
uint64_t stp_attribute_guess(const stp_attribute *attribute, const stp_sample *sample);

/* The numbers of one chunk, in the stored order: packed point after packed point. */
typedef struct stp_attribute_numbers {
    const uint8_t *packed; /* by place in the order */
    const uint32_t *ends;  /* of the parts: stp_attribute_order.ends */
    /* By place: the sample that holds the number. NULL if no attribute is coarse. */
    const stp_sample *holders;
} stp_attribute_numbers;

/* Appends all parts to *out, attribute by attribute, and fills rows[list->count]; offsets count
 * from the begin of *out. Errors: OUT_OF_MEMORY, INTERNAL. */
stp_status stp_attribute_numbers_encode(const stp_attribute_list *list,
                                        const stp_attribute_numbers *numbers, stp_bytes *out,
                                        stp_attribute_row *rows, stp_error *err);

#endif
